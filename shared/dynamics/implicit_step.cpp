#include "shared/dynamics/implicit_step.hpp"

#include <algorithm>
#include <cmath>

#include "shared/dynamics/implicit_joints.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr int kIterations = 24, kProducts = 400, kTrials = 8, kFrictionIterations = 6;
constexpr double kLinearShare = 1e-3;  // to which each linear system is solved
constexpr double kSlopeLeft = 0.25;    // of a search along a line, beyond its end

}  // namespace

ImplicitStep::ImplicitStep(const Description& description, double tolerance_m_s)
    : CoupledStep(description),
      tolerance_m_s_(tolerance_m_s),
      springs_(description),
      joints_(joint_couplings(description)),
      gradients_(velocities_.size(), awake_) {
  for (Motions* all : {&base_, &residual_, &wanted_, &change_}) all->resize(velocities_.size());
  inverses_.nodes.resize(description.nodes.size());
  inverses_.rigid.resize(description.rigid_bodies.size());
  spin_masses_.resize(description.rigid_bodies.size());
  momenta_.resize(description.rigid_bodies.size());
}

void ImplicitStep::leave_out(const Sleep& sleep) {
  CoupledStep::leave_out(sleep);
  springs_.leave_out(sleep.nodes());
  leave_out_joints(sleep.nodes(), sleep.rigid_bodies(), joints_);
  for (Motions* all : {&residual_, &wanted_, &change_})
    std::fill(all->begin(), all->end(), Vector4());
  gradients_.clear();
}

void ImplicitStep::start(const SceneState& state, double step_s) {
  CoupledStep::start(state, step_s);
  for (const std::size_t r : bodies_)
    momenta_[r] = Vector4(turned_inertia(state.orientation[r].quaternion(),
                                         description_.rigid_bodies[r].inertia_kg_m2) *
                          state.angular_velocity_rad_s[r].vector());
  springs_.start(state.node_position_m);
}

/// Whether a body that a force holds turns far: the arms of forces are means of a small turn, and
/// at a whole turn the equations have more solutions than one.
bool ImplicitStep::turns_far() const {
  constexpr double kLargestTurn_rad = 1.0;
  const auto is_far = [&](const ActedPoint& point) {
    if (point.rigid < 0 || is_driven(point, description_)) return false;
    const auto r = static_cast<std::size_t>(point.rigid);
    return poses_.step_s() * velocities_[poses_.spin(r)].vector().norm() > kLargestTurn_rad;
  };
  return std::ranges::any_of(active_, [&](const Coupling* coupling) {
    return is_far(coupling->a) || is_far(coupling->b);
  });
}

void ImplicitStep::restart(const ContactListing& listing) {
  contacts_.start(poses_, listing);
  contacts_.turn_stretches(poses_);
  evaluate();
  limit_friction();
}

void ImplicitStep::limit_friction() {
  contacts_.limit_friction();
  if (!contacts_.couplings().empty()) evaluate();
}

/// Shortens the change until the residual along it has not turned round by much: the equations are
/// nearly the derivative of a convex function along the line.
double ImplicitStep::search_line() {
  each_awake(awake_, [&](std::size_t i) { base_[i] = velocities_[i]; });
  const double before = -dot(residual_, change_, awake_);
  double length = 1.0;
  for (int trial = 0;; ++trial) {
    each_awake(awake_, [&](std::size_t i) { velocities_[i] = base_[i] + length * change_[i]; });
    evaluate();
    const double after = dot(residual_, change_, awake_);
    if (trial == kTrials || after <= kSlopeLeft * before) return length;
    length *= std::max(0.1, before / (before + after));
  }
}

void ImplicitStep::solve(SolveFigures& figures, const std::atomic<bool>* stop) {
  double residual = residual_m_s();
  for (int k = 0; k < kIterations && residual > tolerance_m_s_; ++k) {
    if (stop != nullptr && *stop) break;
    factorise();
    each_awake(awake_, [&](std::size_t i) { wanted_[i] = -1.0 * residual_[i]; });
    figures.products += gradients_.solve(
        wanted_, kLinearShare, 0.0, kProducts,
        [&](const Motions& p, Motions& out) { multiply(p, out); },
        [&](const Motions& r, Motions& out) { precondition(r, out); }, change_);
    contacts_.aim_friction(poses_, change_);
    contacts_.turn_aims(search_line());
    if (k < kFrictionIterations)
      limit_friction();
    else if (!contacts_.couplings().empty())
      evaluate();  // directions of friction have changed
    residual = residual_m_s();
    ++figures.iterations;
  }
  figures.converged = residual <= tolerance_m_s_;
  figures.residual_m_s = residual;
}

EnergyLosses ImplicitStep::losses() const {
  EnergyLosses losses;
  losses.spring_damping_J = springs_.damping_J(poses_.to().node_position_m, poses_.step_s()) +
                            joint_damping_J(description_, poses_, velocities_, joints_);
  contacts_.add_losses(poses_, velocities_, losses);
  return losses;
}

EngineMethod implicit_euler(double tolerance_m_s) {
  const auto make = [](const Description& description, double tolerance) {
    return std::unique_ptr<CoupledStep>(std::make_unique<ImplicitStep>(description, tolerance));
  };
  return {.make = make, .has_end_forces = true, .tolerance_m_s = tolerance_m_s};
}

}  // namespace stillgrid::dynamics
