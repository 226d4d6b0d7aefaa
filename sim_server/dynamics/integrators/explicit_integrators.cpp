#include "sim_server/dynamics/integrators/explicit_integrators.hpp"

#include <algorithm>
#include <cmath>

#include "sim_server/bodies/rotation.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kMaxSubsteps = 1e6;
/// Contacts are those met on the way, so the way is short.
constexpr double kLongestPart_s = 4e-3;
/// Of the smaller radius, that two spheres come nearer in a substep: none passes another unseen,
/// and the normals of spheres that collide turn little.
constexpr double kMaxApproach = 0.2;
/// Of substeps in which contacts are not solved.
constexpr int kMaxHalvings = 5;
/// Rigid bodies that one thread takes at once, and below which threads cost more than they take.
constexpr std::size_t kBodiesAChunk = 512, kBodiesWorthSharing = 2048;

/// Written so that no number asks for one.
int whole_substeps(double asked) {
  return asked > 1.0 ? static_cast<int>(std::ceil(std::min(asked, kMaxSubsteps))) : 1;
}

int substeps_of_contacts(double rate_per_s2, double duration_s) {
  // A little more than asked, so that rounding asks for no third try.
  return whole_substeps(1.01 * duration_s * contact_substeps_per_s(rate_per_s2));
}

/// By the spin of the middle, as explicit midpoint has it: of second order also where the spin
/// changes as the body turns.
void turn(RigidState& body, double turn_s) {
  const Eigen::Vector3d& inverse = body.inverse_principal_inertia_per_kg_m2;
  const Eigen::Quaterniond start = body.orientation;
  if (inverse.x() != inverse.y() || inverse.y() != inverse.z()) {
    body.orientation = bodies::rotation_of(0.5 * turn_s * body.spin_rad_s) * start;
    body.turn_inertia();
    body.spin_rad_s = body.inverse_inertia_per_kg_m2 * body.angular_momentum_N_m_s;
  }
  body.orientation = (bodies::rotation_of(turn_s * body.spin_rad_s) * start).normalized();
  body.turn_inertia();
  body.spin_rad_s = body.inverse_inertia_per_kg_m2 * body.angular_momentum_N_m_s;
}

}  // namespace

IntegratorTraits ExplicitIntegrator::traits() const noexcept {
  IntegratorTraits traits{.always_advances = true, .divides_itself = true};
  if (method_.substeps > 0) return traits;  // as asked, however far apart
  traits.looks_within = true;
  traits.longest_part_s = kLongestPart_s;
  return traits;
}

SolveReport ExplicitIntegrator::advance(const bodies::World& world,
                                        std::span<const contact::Contact> contacts,
                                        double duration_s, Budget& budget) {
  if (!springs_) {
    springs_.emplace(world);
    spring_rates_ = bound_springs(world);
    joints_.emplace(world);
  }
  SolveReport report;
  // If contacts cannot be solved or are too stiff for the substeps, the part begins anew with more.
  for (int halvings = 0;; ++halvings) {
    pack(world);
    contacts_.take(world, contacts);
    flow_ = {};
    const int needed = substeps_of_contacts(contact_rate_per_s2_, duration_s);
    contact_rate_per_s2_ = 0.0;
    substeps_ = halvings == 0 ? substeps_for(world, duration_s) : std::max(2 * substeps_, needed);
    const bool may_halve = halvings < kMaxHalvings && method_.substeps == 0;
    const bool is_free = contacts.empty() && world.joints.empty();
    report = is_free ? move_freely(world, duration_s, budget)
                     : move(world, duration_s, may_halve, budget);
    if (report.converged || !may_halve || budget.is_late() || report.iterations == substeps_) break;
  }
  unpack(world, duration_s);
  report.converged = trial_.is_finite && report.converged;
  return report;
}

/// Substep after substep; if it may be tried again with shorter ones, as far as contacts are
/// solved.
SolveReport ExplicitIntegrator::move(const bodies::World& world, double duration_s, bool may_halve,
                                     const Budget& budget) {
  const double substep_s = duration_s / substeps_;
  SolveReport report{.converged = true};
  double due_s = 0.5 * substep_s;
  for (; report.iterations < substeps_; ++report.iterations) {
    if (budget.is_late()) {
      report.converged = false;
      break;
    }
    drift(world, due_s);
    due_s = substep_s;
    const ContactSolve solve =
        substep(world, (report.iterations + 0.5) * substep_s, substep_s, duration_s, budget);
    const bool too_stiff = may_halve && solve.stiffness_ratio > kContactRatio;
    if (solve.converged && !too_stiff) continue;
    report.converged = false;
    if (may_halve || solve.late) break;
  }
  drift(world, due_s - 0.5 * substep_s);
  return report;
}

/// The same, to the bit, where there are no joints and no contact is known: a substep is one pass
/// over what moves.
SolveReport ExplicitIntegrator::move_freely(const bodies::World& world, double duration_s,
                                            const Budget& budget) {
  const double substep_s = duration_s / substeps_;
  const double half_s = 0.5 * substep_s;
  SolveReport report{.converged = true};
  // Takes what contacts held that are gone.
  contacts_.begin(0.0, duration_s, substep_s, world.gravity_m_s2, state_);
  (void)contacts_.solve(substep_s, budget, state_, flow_);
  drift(world, half_s);
  springs_->take(world, state_);
  for (; report.iterations < substeps_; ++report.iterations) {
    if (budget.is_late()) {
      report.converged = false;
      break;
    }
    const bool last = report.iterations + 1 == substeps_;
    const Move move{.kick_s = substep_s, .drift_s = last ? half_s : substep_s};
    flow_.spring_damping_J += substep_s * springs_->move(world, move, state_);
    kick_rigid(world, move.kick_s);
    drift_rigid(move.drift_s);
  }
  springs_->give(world, state_);
  if (!report.converged) drift(world, -half_s);
  return report;
}

void ExplicitIntegrator::commit(bodies::World& world, double duration_s) {
  Integrator::commit(world, duration_s);
  contacts_.keep();
  kept_contact_rate_per_s2_ = contact_rate_per_s2_;
}

void ExplicitIntegrator::share_work(const Workers& workers) {
  workers_ = &workers;
  contacts_.share_work(workers);
}

template <class Work>
void ExplicitIntegrator::for_each_free(const Work& work) {
  const Workers& workers = state_.rigid.size() < kBodiesWorthSharing ? Workers::alone() : *workers_;
  workers.for_each(state_.rigid.size(), kBodiesAChunk, [&](std::size_t i) {
    if (state_.rigid[i].free) work(state_.rigid[i]);
  });
}

void ExplicitIntegrator::restart() {
  springs_.reset();
}

int ExplicitIntegrator::substeps_for(const bodies::World& world, double duration_s) {
  if (method_.substeps > 0) return method_.substeps;
  const SpringRates joints = joints_->bound(world, duration_s);
  const SpringRates rates{spring_rates_.stiffness_per_s2 + joints.stiffness_per_s2,
                          spring_rates_.damping_per_s + joints.damping_per_s};
  const int of_motion = whole_substeps(
      duration_s *
      std::max(substeps_per_s(rates), contacts_.approach_per_s(state_, duration_s) / kMaxApproach));
  return std::max(of_motion, substeps_of_contacts(kept_contact_rate_per_s2_, duration_s));
}

ContactSolve ExplicitIntegrator::substep(const bodies::World& world, double at_s, double substep_s,
                                         double step_s, const Budget& budget) {
  for (std::size_t i = 0; i < state_.rigid.size(); ++i) {
    const bodies::RigidBody& body = world.rigid_bodies[i];
    if (body.free) continue;
    const bodies::PrescribedState state = bodies::prescribed_state(body, world.time_s + at_s);
    state_.rigid[i].position_m = state.position_m;
    state_.rigid[i].velocity_m_s = state.velocity_m_s;
  }
  flow_.spring_damping_J += substep_s * springs_->evaluate(world, state_);
  const JointPower joints = pull_joints(world, state_);
  flow_.spring_damping_J += substep_s * joints.damping_W;
  flow_.given_J += substep_s * joints.given_W;
  contacts_.begin(at_s / step_s, step_s, substep_s, world.gravity_m_s2, state_);
  kick(world, substep_s);
  const ContactSolve solve = contacts_.solve(substep_s, budget, state_, flow_);
  contact_rate_per_s2_ =
      std::max(contact_rate_per_s2_, solve.stiffness_ratio / (substep_s * substep_s));
  return solve;
}

void ExplicitIntegrator::kick(const bodies::World& world, double kick_s) {
  move_nodes({.kick_s = kick_s}, world.gravity_m_s2, state_);
  kick_rigid(world, kick_s);
}

void ExplicitIntegrator::kick_rigid(const bodies::World& world, double kick_s) {
  for_each_free([&](RigidState& body) {
    body.velocity_m_s += kick_s * (body.inverse_mass_per_kg * body.force_N + world.gravity_m_s2);
    body.angular_momentum_N_m_s += kick_s * body.torque_N_m;
    body.spin_rad_s = body.inverse_inertia_per_kg_m2 * body.angular_momentum_N_m_s;
    body.force_N.setZero();
    body.torque_N_m.setZero();
  });
}

void ExplicitIntegrator::drift(const bodies::World& world, double drift_s) {
  if (drift_s == 0.0) return;
  move_nodes({.drift_s = drift_s}, world.gravity_m_s2, state_);
  drift_rigid(drift_s);
}

void ExplicitIntegrator::drift_rigid(double drift_s) {
  for_each_free([&](RigidState& body) {
    body.position_m += drift_s * body.velocity_m_s;
    turn(body, drift_s);
  });
}

}  // namespace stillgrid::dynamics
