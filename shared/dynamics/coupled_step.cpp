#include "shared/dynamics/coupled_step.hpp"

#include <algorithm>
#include <cmath>

#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {
namespace {

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

CoupledStep::CoupledStep(const Description& description)
    : description_(description),
      poses_(description),
      contacts_(description),
      reaches_m_(reaches_m(description)) {
  for (Motions* all : {&velocities_, &impulses_, &driven_impulses_})
    all->resize(description.nodes.size() + 2 * description.rigid_bodies.size());
}

void CoupledStep::leave_out(const Sleep& sleep) {
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
  contacts_.leave_out(sleep.spheres());
  std::fill(velocities_.begin(), velocities_.end(), Vector4());
}

void CoupledStep::start(const SceneState& state, double step_s) {
  poses_.start(state, step_s);
  for (const std::size_t i : nodes_) velocities_[i] = state.node_velocity_m_s[i];
  for (std::size_t r = 0; r < description_.rigid_bodies.size(); ++r) {
    velocities_[poses_.centre(r)] = state.rigid_velocity_m_s[r];
    velocities_[poses_.spin(r)] = state.angular_velocity_rad_s[r];
  }
  for (const std::size_t r : bodies_) {
    Eigen::Quaterniond end = state.orientation[r].quaternion();
    Eigen::Vector3d spin = state.angular_velocity_rad_s[r].vector();
    turn_freely(end, spin, description_.rigid_bodies[r].inertia_kg_m2, step_s);
    velocities_[poses_.spin(r)] = Vector4(spin);
  }
  poses_.move(velocities_, awake_);
}

void CoupledStep::write_velocities(SceneState& state) const {
  for (const std::size_t i : nodes_) state.node_velocity_m_s[i] = velocities_[i];
  for (const std::size_t r : bodies_) {
    state.rigid_velocity_m_s[r] = velocities_[poses_.centre(r)];
    state.angular_velocity_rad_s[r] = velocities_[poses_.spin(r)];
  }
}

void CoupledStep::finish(SceneState& state, ContactListing& listing,
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

void CoupledStep::add_contact_impulses() {
  for (const Coupling& contact : contacts_.couplings()) {
    if (!contact.is_active) continue;
    const auto add = [&](Motions& sums) {
      add_impulse(contact.a, contact.impulse_N_s, poses_, sums);
      add_impulse(contact.b, -contact.impulse_N_s, poses_, sums);
    };
    add(impulses_);
    if (is_driven(contact.a, description_) && is_driven(contact.b, description_))
      add(driven_impulses_);
  }
}

void CoupledStep::add_reaction(std::size_t rigid, DrivenReaction& reaction) const {
  const std::size_t centre = poses_.centre(rigid), spin = poses_.spin(rigid);
  reaction.impulse_N_s += impulses_[centre].vector();
  reaction.moment_N_m_s += impulses_[spin].vector();
  reaction.rigid_impulse_N_s += driven_impulses_[centre].vector();
  reaction.rigid_moment_N_m_s += driven_impulses_[spin].vector();
}

}  // namespace stillgrid::dynamics
