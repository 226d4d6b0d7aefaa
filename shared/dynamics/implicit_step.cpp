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

/// Distances of the farthest points of rigid bodies, or radii of gyration where they have none.
std::vector<double> reaches_m(const Description& description) {
  std::vector<double> reaches;
  for (const Description::Rigid& body : description.rigid_bodies)
    reaches.push_back(body.is_driven ? 0.0
                                     : std::sqrt(body.inertia_kg_m2.maxCoeff() / body.mass_kg));
  for (const Description::Sphere& sphere : description.spheres) {
    if (sphere.rigid < 0) continue;
    double& reach = reaches[static_cast<std::size_t>(sphere.rigid)];
    reach = std::max(reach, sphere.local_m.norm() + sphere.radius_m);
  }
  return reaches;
}

}  // namespace

ImplicitStep::ImplicitStep(const Description& description, double tolerance_m_s)
    : description_(description),
      tolerance_m_s_(tolerance_m_s),
      poses_(description),
      springs_(description),
      joints_(joint_couplings(description)),
      contacts_(description),
      gradients_(description.nodes.size() + 2 * description.rigid_bodies.size(), awake_) {
  const std::size_t count = description.nodes.size() + 2 * description.rigid_bodies.size();
  for (Motions* all : {&velocities_, &base_, &residual_, &wanted_, &change_, &impulses_})
    all->resize(count);
  inverses_.nodes.resize(description.nodes.size());
  inverses_.rigid.resize(description.rigid_bodies.size());
  spin_masses_.resize(description.rigid_bodies.size());
  momenta_.resize(description.rigid_bodies.size());
  reaches_m_ = reaches_m(description);
}

void ImplicitStep::leave_out(const Sleep& sleep) {
  const std::size_t nodes = sleep.nodes().size(), bodies = sleep.rigid_bodies().size();
  nodes_.clear();
  bodies_.clear();
  awake_.clear();
  const auto add = [&](std::size_t i) {
    if (awake_.empty() || awake_.back().second != i) awake_.emplace_back(i, i);
    awake_.back().second = i + 1;
  };
  for (std::size_t i = 0; i < nodes; ++i) {
    if (sleep.nodes()[i] != 0) continue;
    add(i);
    if (!description_.nodes[i].is_pinned) nodes_.push_back(i);
  }
  for (std::size_t r = 0; r < bodies; ++r)
    if (sleep.rigid_bodies()[r] == 0) {
      add(nodes + r);
      if (!description_.rigid_bodies[r].is_driven) bodies_.push_back(r);
    }
  for (std::size_t r = 0; r < bodies; ++r)
    if (sleep.rigid_bodies()[r] == 0) add(nodes + bodies + r);
  springs_.leave_out(sleep.nodes());
  leave_out_joints(sleep.nodes(), sleep.rigid_bodies(), joints_);
  contacts_.leave_out(sleep.spheres());
  for (Motions* all : {&velocities_, &residual_, &wanted_, &change_})
    std::fill(all->begin(), all->end(), Vector4());
  gradients_.clear();
}

void ImplicitStep::start(const SceneState& state, double step_s) {
  poses_.start(state, step_s);
  for (const std::size_t i : nodes_) velocities_[i] = state.node_velocity_m_s[i];
  for (std::size_t r = 0; r < momenta_.size(); ++r) {
    velocities_[poses_.centre(r)] = state.rigid_velocity_m_s[r];
    velocities_[poses_.spin(r)] = state.angular_velocity_rad_s[r];
  }
  for (const std::size_t r : bodies_) {
    const Eigen::Quaterniond orientation = state.orientation[r].quaternion();
    const Eigen::Vector3d& inertia = description_.rigid_bodies[r].inertia_kg_m2;
    Eigen::Vector3d spin = state.angular_velocity_rad_s[r].vector();
    momenta_[r] = Vector4(turned_inertia(orientation, inertia) * spin);
    Eigen::Quaterniond end = orientation;
    turn_freely(end, spin, inertia, step_s);
    velocities_[poses_.spin(r)] = Vector4(spin);
  }
  springs_.start(state.node_position_m);
  poses_.move(velocities_, awake_);
}

/// Whether a body that a force holds turns far: the arms of forces are means of a small turn, and
/// at a whole turn the equations have more solutions than one.
bool ImplicitStep::turns_far() const {
  constexpr double kLargestTurn_rad = 1.0;
  const auto is_far = [&](const ActedPoint& point) {
    if (point.rigid < 0) return false;
    const auto r = static_cast<std::size_t>(point.rigid);
    const double turn_rad = poses_.step_s() * velocities_[poses_.spin(r)].vector().norm();
    return turn_rad > kLargestTurn_rad && !description_.rigid_bodies[r].is_driven;
  };
  return std::ranges::any_of(active_, [&](const Coupling* coupling) {
    return is_far(coupling->a) || is_far(coupling->b);
  });
}

void ImplicitStep::restart(const ContactListing& listing) {
  contacts_.start(poses_, listing);
  evaluate();
  contacts_.limit_friction();
  if (!contacts().empty()) evaluate();
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
    if (k < kFrictionIterations) contacts_.limit_friction();
    if (!contacts().empty()) evaluate();  // friction has changed
    residual = residual_m_s();
    ++figures.iterations;
  }
  figures.converged = residual <= tolerance_m_s_;
  figures.residual_m_s = residual;
}

void ImplicitStep::write_velocities(SceneState& state) const {
  for (const std::size_t i : nodes_) state.node_velocity_m_s[i] = velocities_[i];
  for (const std::size_t r : bodies_) {
    state.rigid_velocity_m_s[r] = velocities_[poses_.centre(r)];
    state.angular_velocity_rad_s[r] = velocities_[poses_.spin(r)];
  }
}

void ImplicitStep::finish(SceneState& state, ContactListing& listing,
                          std::vector<SpherePlace>& places) const {
  write_velocities(state);
  state.node_position_m = poses_.to().node_position_m;
  state.rigid_position_m = poses_.to().rigid_position_m;
  for (std::size_t r = 0; r < state.orientation.size(); ++r)
    if (!velocities_[poses_.spin(r)].vector().isZero(0.0))  // else rounding would turn it
      state.orientation[r] = poses_.to().orientation[r];
  contacts_.write(listing.rows());
  contacts_.write_places(listing, places);
}

EnergyLosses ImplicitStep::losses() const {
  EnergyLosses losses;
  losses.spring_damping_J = springs_.damping_J(poses_.to().node_position_m, poses_.step_s()) +
                            joint_damping_J(description_, poses_, velocities_, joints_);
  contacts_.add_losses(poses_, velocities_, losses);
  return losses;
}

}  // namespace stillgrid::dynamics
