#include "sim_server/dynamics/integrators/explicit_integrators.hpp"

#include <algorithm>
#include <cmath>

#include "sim_server/bodies/rotation.hpp"
#include "sim_server/bodies/sphere_motion.hpp"

namespace stillgrid::dynamics {
namespace {

/// What power iteration misses, and what springs stiffen within a step, of their eigenvalues.
constexpr double kSpringMargin = 1.1;
/// Substeps in which springs do not deform so much that their eigenvalues need another look.
constexpr int kSubstepsALook = 16;
constexpr double kMaxSubsteps = 1e6;
/// Contacts are those met on the way, so the way is short.
constexpr double kLongestPart_s = 4e-3;
/// Of a substep, h^2 omega^2 / 2 of what touches: with less, substeps cost more than iterations.
constexpr double kContactRatio = 16.0;
/// Of the smaller radius, that two spheres come nearer in a substep: none passes another unseen.
constexpr double kMaxApproach = 0.5;
/// Of substeps in which contacts are not solved.
constexpr int kMaxHalvings = 5;

void turn_inertia(RigidState& body) {
  body.rotation = body.orientation.toRotationMatrix();
  const Eigen::Matrix3d& r = body.rotation;
  body.inverse_inertia_per_kg_m2 =
      r * body.inverse_principal_inertia_per_kg_m2.asDiagonal() * r.transpose();
}

}  // namespace

IntegratorTraits ExplicitIntegrator::traits() const noexcept {
  IntegratorTraits traits{.always_advances = true, .divides_itself = true};
  if (method_.substeps > 0) return traits;  // as asked, however far apart
  traits.looks_within = true;
  traits.longest_part_s = kLongestPart_s;
  return traits;
}

ExplicitIntegrator::ExplicitIntegrator(const scene::Method& method)
    : ExplicitIntegrator(method, method.integrator == scene::IntegratorKind::kVelocityVerlet
                                     ? Drifts{0.5, 0.5}
                                     : Drifts{0.0, 1.0}) {}

SolveReport ExplicitIntegrator::advance(const bodies::World& world,
                                        std::span<const contact::Contact> contacts,
                                        double duration_s, Budget& budget) {
  if (!springs_) springs_.emplace(world);
  SolveReport report;
  // Where contacts cannot be solved substeps are halved, all of the part's, so that it begins anew.
  for (int halvings = 0;; ++halvings) {
    pack(world);
    contacts_.take(world, contacts);
    flow_ = {};
    contact_rate_per_s2_ = 0.0;
    substeps_ = halvings == 0 ? substeps_for(world, duration_s) : 2 * substeps_;
    const bool may_halve = halvings < kMaxHalvings && method_.substeps == 0;
    // Drifts of zero: what apply() does is no kick.
    report = contacts.empty() && drifts_.after > 0.0 ? move_freely(world, duration_s, budget)
                                                     : move(world, duration_s, may_halve, budget);
    if (report.converged || !may_halve || budget.is_late() || report.iterations == substeps_) break;
  }
  since_look_ += substeps_;
  report.converged = unpack(world, duration_s) && report.converged;
  return report;
}

/// Substep after substep; if it may be tried again with shorter ones, as far as contacts are
/// solved.
SolveReport ExplicitIntegrator::move(const bodies::World& world, double duration_s, bool may_halve,
                                     const Budget& budget) {
  const double substep_s = duration_s / substeps_;
  SolveReport report{.converged = true};
  drift_to_substep(world, substep_s);
  double due_s = drifts_.before * substep_s;
  for (; report.iterations < substeps_; ++report.iterations) {
    if (budget.is_late()) {
      report.converged = false;
      break;
    }
    drift(world, due_s);
    due_s = (drifts_.after + drifts_.before) * substep_s;
    const ContactSolve solve = substep(world, (report.iterations + drifts_.before) * substep_s,
                                       substep_s, duration_s, budget);
    if (solve.converged) continue;
    report.converged = false;
    if (may_halve || solve.late) break;
  }
  drift(world, due_s - drifts_.before * substep_s);
  return report;
}

/// The same, to the bit, where no contact is known: a substep is one pass over what moves.
SolveReport ExplicitIntegrator::move_freely(const bodies::World& world, double duration_s,
                                            const Budget& budget) {
  const double substep_s = duration_s / substeps_;
  const double before_s = drifts_.before * substep_s;
  const double due_s = (drifts_.after + drifts_.before) * substep_s;
  SolveReport report{.converged = true};
  drift_to_substep(world, substep_s);
  // Takes what contacts held that are gone.
  contacts_.begin(0.0, duration_s, substep_s, world.gravity_m_s2, state_);
  (void)contacts_.solve(substep_s, budget, state_, flow_);
  drift(world, before_s);
  springs_->take(world, state_);
  for (; report.iterations < substeps_; ++report.iterations) {
    if (budget.is_late()) {
      report.converged = false;
      break;
    }
    const bool last = report.iterations + 1 == substeps_;
    const Move move{.kick_s = substep_s, .drift_s = last ? due_s - before_s : due_s};
    flow_.spring_damping_J += substep_s * springs_->move(world, move, state_);
    kick_rigid(world, move.kick_s);
    drift_rigid(move.drift_s);
  }
  springs_->give(world, state_);
  if (!report.converged) drift(world, -before_s);
  return report;
}

/// Positions of symplectic Euler are ahead by half a substep: also of one that is longer or shorter
/// than the last, or contacts would not begin where they ended.
void ExplicitIntegrator::drift_to_substep(const bodies::World& world, double substep_s) {
  const double last_s = kept_substep_s_ > 0.0 ? kept_substep_s_ : substep_s;
  drift(world, 0.5 * (drifts_.after - drifts_.before) * (substep_s - last_s));
}

void ExplicitIntegrator::commit(bodies::World& world, double duration_s) {
  Integrator::commit(world, duration_s);
  contacts_.keep();
  kept_substep_s_ = duration_s / substeps_;
  kept_contact_rate_per_s2_ = contact_rate_per_s2_;
}

void ExplicitIntegrator::restart() {
  springs_.reset();
  spectrum_.restart();
  since_look_ = kNeverLooked;
  kept_substep_s_ = 0.0;
}

void ExplicitIntegrator::pack(const bodies::World& world) {
  state_.position_m.resize(world.nodes.size());
  state_.velocity_m_s.resize(world.nodes.size());
  state_.force_N.resize(world.nodes.size());
  state_.inverse_mass_per_kg.resize(world.nodes.size());
  for (std::size_t i = 0; i < world.nodes.size(); ++i) {
    const bodies::Node& node = world.nodes[i];
    state_.position_m[i].map() = node.position_m;
    state_.velocity_m_s[i].map() = node.velocity_m_s;
    state_.inverse_mass_per_kg[i] = node.unknown == bodies::kNoUnknown ? 0.0 : 1.0 / node.mass_kg;
  }
  state_.rigid.resize(world.rigid_bodies.size());
  for (std::size_t i = 0; i < world.rigid_bodies.size(); ++i) {
    const bodies::RigidBody& body = world.rigid_bodies[i];
    RigidState& state = state_.rigid[i];
    state = {};
    state.position_m = body.position_m;
    state.velocity_m_s = body.velocity_m_s;
    state.orientation = body.orientation;
    state.free = body.unknown != bodies::kNoUnknown;
    if (state.free) state.inverse_principal_inertia_per_kg_m2 = body.inertia_kg_m2.cwiseInverse();
    turn_inertia(state);
    if (!state.free) continue;
    state.spin_rad_s = body.angular_velocity_rad_s;
    state.inverse_mass_per_kg = 1.0 / body.mass_kg;
    state.angular_momentum_N_m_s =
        body.orientation *
        body.inertia_kg_m2.cwiseProduct(body.orientation.conjugate() * body.angular_velocity_rad_s);
  }
}

int ExplicitIntegrator::substeps_for(const bodies::World& world, double duration_s) {
  if (method_.substeps > 0) return method_.substeps;
  if (since_look_ >= kSubstepsALook) {
    rates_ = spectrum_.follow(world, state_, *springs_);
    since_look_ = 0;
  }
  const double k_per_s2 = kSpringMargin * rates_.stiffness_per_s2;
  const double c_per_s = kSpringMargin * rates_.damping_per_s;
  // The largest h with h^2 k + 2 h c = 4, as a rate so that none is zero.
  const double per_s = 0.25 * (c_per_s + std::sqrt(c_per_s * c_per_s + 4.0 * k_per_s2));
  const double asked =
      duration_s * std::max({per_s, std::sqrt(kept_contact_rate_per_s2_ / kContactRatio),
                             contacts_.approach_per_s(state_, duration_s) / kMaxApproach});
  // Written so that no number asks for one.
  return asked > 1.0 ? static_cast<int>(std::ceil(std::min(asked, kMaxSubsteps))) : 1;
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
  contacts_.begin(at_s / step_s, step_s, substep_s, world.gravity_m_s2, state_);
  apply(world, substep_s);
  const ContactSolve solve = contacts_.solve(substep_s, budget, state_, flow_);
  contact_rate_per_s2_ =
      std::max(contact_rate_per_s2_, contacts_.stiffness_ratio() / (substep_s * substep_s));
  return solve;
}

void ExplicitIntegrator::apply(const bodies::World& world, double substep_s) {
  kick(world, substep_s);
}

void ExplicitIntegrator::kick(const bodies::World& world, double kick_s) {
  move_nodes({.kick_s = kick_s}, world.gravity_m_s2, state_);
  kick_rigid(world, kick_s);
}

void ExplicitIntegrator::kick_rigid(const bodies::World& world, double kick_s) {
  for (RigidState& body : state_.rigid) {
    if (!body.free) continue;
    body.velocity_m_s += kick_s * (body.inverse_mass_per_kg * body.force_N + world.gravity_m_s2);
    body.angular_momentum_N_m_s += kick_s * body.torque_N_m;
    body.spin_rad_s = body.inverse_inertia_per_kg_m2 * body.angular_momentum_N_m_s;
    body.force_N.setZero();
    body.torque_N_m.setZero();
  }
}

void ExplicitIntegrator::drift(const bodies::World& world, double drift_s) {
  if (drift_s == 0.0) return;
  move_nodes({.drift_s = drift_s}, world.gravity_m_s2, state_);
  drift_rigid(drift_s);
}

void ExplicitIntegrator::drift_rigid(double drift_s) {
  for (RigidState& body : state_.rigid) {
    if (!body.free) continue;
    body.position_m += drift_s * body.velocity_m_s;
    body.orientation =
        (bodies::rotation_of(drift_s * body.spin_rad_s) * body.orientation).normalized();
    turn_inertia(body);
    body.spin_rad_s = body.inverse_inertia_per_kg_m2 * body.angular_momentum_N_m_s;
  }
}

/// False, and the trial is the world at rest, if something is no number.
bool ExplicitIntegrator::unpack(const bodies::World& world, double duration_s) {
  trial_.nodes = world.nodes;
  trial_.rigid_bodies = world.rigid_bodies;
  bool finite = true;
  for (std::size_t i = 0; i < trial_.nodes.size(); ++i) {
    bodies::Node& node = trial_.nodes[i];
    if (node.unknown == bodies::kNoUnknown) continue;
    node.position_m = state_.position_m[i].map();
    node.velocity_m_s = state_.velocity_m_s[i].map();
    finite = finite && node.position_m.allFinite() && node.velocity_m_s.allFinite();
  }
  for (std::size_t i = 0; i < trial_.rigid_bodies.size(); ++i) {
    bodies::RigidBody& body = trial_.rigid_bodies[i];
    RigidState& state = state_.rigid[i];
    if (!body.free) {
      const bodies::PrescribedState end = bodies::prescribed_state(body, world.time_s + duration_s);
      state.position_m = body.position_m = end.position_m;
      state.velocity_m_s = body.velocity_m_s = end.velocity_m_s;
    }
    if (!state.free) continue;
    body.position_m = state.position_m;
    body.velocity_m_s = state.velocity_m_s;
    body.orientation = state.orientation;
    body.angular_velocity_rad_s = state.spin_rad_s;
    finite = finite && body.position_m.allFinite() && body.velocity_m_s.allFinite() &&
             body.orientation.coeffs().allFinite() && body.angular_velocity_rad_s.allFinite();
  }
  trial_.struck = contacts_.struck();
  trial_.touching = finite ? contacts_.count_touching(state_) : 0;
  if (!finite) rest(world);
  trial_.spheres.resize(world.spheres.size());
  bodies::SphereMotions motion_of(trial_.nodes, trial_.rigid_bodies);
  for (std::size_t i = 0; i < world.spheres.size(); ++i)
    trial_.spheres[i] = motion_of(world.spheres[i]);
  return finite;
}

void ExplicitIntegrator::rest(const bodies::World& world) {
  trial_.nodes = world.nodes;
  trial_.rigid_bodies = world.rigid_bodies;
  for (bodies::Node& node : trial_.nodes) node.velocity_m_s.setZero();
  for (bodies::RigidBody& body : trial_.rigid_bodies) {
    body.velocity_m_s.setZero();
    body.angular_velocity_rad_s.setZero();
  }
  flow_ = {};
}

}  // namespace stillgrid::dynamics
