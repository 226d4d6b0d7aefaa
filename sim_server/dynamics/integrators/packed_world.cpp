// A world as an explicit integrator moves it, and back.
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/dynamics/integrators/explicit_integrators.hpp"

namespace stillgrid::dynamics {

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
    state.turn_inertia();
    if (!state.free) continue;
    state.spin_rad_s = body.angular_velocity_rad_s;
    state.inverse_mass_per_kg = 1.0 / body.mass_kg;
    state.angular_momentum_N_m_s =
        body.orientation *
        body.inertia_kg_m2.cwiseProduct(body.orientation.conjugate() * body.angular_velocity_rad_s);
  }
}

void ExplicitIntegrator::unpack(const bodies::World& world, double duration_s) {
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
  trial_.is_finite = finite;
  if (!finite) return;
  trial_.touching = contacts_.count_touching(state_);
  trial_.spheres.resize(world.spheres.size());
  bodies::SphereMotions motion_of(trial_.nodes, trial_.rigid_bodies);
  for (std::size_t i = 0; i < world.spheres.size(); ++i)
    trial_.spheres[i] = motion_of(world.spheres[i]);
}

}  // namespace stillgrid::dynamics
