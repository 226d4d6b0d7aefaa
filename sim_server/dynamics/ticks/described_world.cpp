#include "sim_server/dynamics/ticks/described_world.hpp"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "sim_server/contact/self_collision.hpp"

namespace stillgrid::dynamics {
namespace {

void add_deformable(const bodies::World& world, DescribedWorld& described) {
  for (const bodies::Node& node : world.nodes) {
    described.description.nodes.push_back({node.mass_kg, node.pinned});
    described.state.node_position_m.emplace_back(node.position_m);
    described.state.node_velocity_m_s.emplace_back(node.velocity_m_s);
  }
  for (const bodies::Spring& spring : world.springs)
    described.description.springs.push_back({spring.a, spring.b, spring.rest_length_m,
                                             spring.stiffness_N_per_m, spring.damping_N_s_per_m});
  const auto end_of = [](const bodies::JointEnd& end) {
    return Description::JointEnd{end.node, end.node >= 0 ? -1 : end.rigid, end.point_m};
  };
  for (const bodies::Joint& joint : world.joints)
    described.description.joints.push_back({end_of(joint.a), end_of(joint.b), joint.rest_length_m,
                                            joint.stiffness_N_per_m, joint.damping_N_s_per_m});
}

int add_rigid(const bodies::RigidBody& body, DescribedWorld& described) {
  described.description.rigid_bodies.push_back({body.mass_kg, body.inertia_kg_m2, !body.free});
  described.state.rigid_position_m.emplace_back(body.position_m);
  described.state.rigid_velocity_m_s.emplace_back(body.velocity_m_s);
  described.state.orientation.emplace_back(body.orientation);
  described.state.angular_velocity_rad_s.emplace_back(body.angular_velocity_rad_s);
  described.state.is_here.push_back(1);
  return static_cast<int>(described.description.rigid_bodies.size()) - 1;
}

void add_moving_spheres(const bodies::World& world, DescribedWorld& described) {
  for (const bodies::SphereBinding& binding : world.spheres) {
    Description::Sphere sphere;
    sphere.radius_m = binding.radius_m;
    sphere.material = binding.material;
    sphere.body = binding.body;
    sphere.rigid = binding.rigid;
    sphere.local_m = binding.local_m;
    sphere.node_count = binding.node_count;
    sphere.nodes = binding.nodes;
    sphere.weights = binding.weights;
    sphere.is_field_point = binding.is_field_point;
    sphere.crushing_force_N = binding.crushing_force_N;
    described.description.spheres.push_back(sphere);
  }
}

/// In the order of World::fields, in which they are published too.
void add_fields(const bodies::World& world, int static_rigid, DescribedWorld& described) {
  for (const bodies::FieldBody& body : world.fields) {
    Description::Field field;
    field.distance = body.field;
    field.rigid = body.rigid < 0 ? static_rigid : body.rigid;
    field.position_m = body.position_m;
    field.orientation = body.orientation;
    field.material = body.material;
    field.body = body.body;
    described.description.fields.push_back(std::move(field));
  }
}

/// All that never moves, and the fields of what does.
void add_static(const bodies::World& world, DescribedWorld& described) {
  for (const bodies::StaticPlane& plane : world.planes)
    described.description.planes.push_back(
        {plane.normal, plane.offset_m, plane.material, plane.body});
  described.has_static_body =
      !world.static_spheres.empty() ||
      std::ranges::any_of(world.fields, [](const bodies::FieldBody& f) { return f.rigid < 0; });
  const int rigid = described.has_static_body ? add_rigid({}, described) : -1;
  if (rigid >= 0) described.description.rigid_bodies.back().is_fixture = true;
  add_fields(world, rigid, described);
  const auto add = [&](const bodies::StaticSphere& fixed, bool is_field_point) {
    Description::Sphere sphere;
    sphere.radius_m = fixed.radius_m;
    sphere.material = fixed.material;
    sphere.body = fixed.body;
    sphere.rigid = rigid;
    sphere.local_m = fixed.position_m;
    sphere.is_field_point = is_field_point;
    described.description.spheres.push_back(sphere);
  };
  for (const bodies::StaticSphere& fixed : world.static_spheres) add(fixed, false);
  for (const bodies::StaticSphere& point : world.static_points) add(point, true);
}

std::vector<std::pair<int, int>> bodies_apart(const bodies::World& world) {
  std::set<std::pair<int, int>> apart;
  for (const auto& [a, b] : world.apart)
    if (a < b) apart.emplace(a, b);
  return {apart.begin(), apart.end()};
}

void add_tools(const bodies::World& world, std::span<const scene::Hand> hands,
               DescribedWorld& described) {
  described.hands = hands.size();
  for (std::size_t hand = 0; hand < hands.size(); ++hand) {
    const int rigid = add_rigid({}, described);
    described.state.is_here.back() = 0;
    for (const scene::ToolSphere& tool : hands[hand].tool) {
      Description::Sphere sphere;
      sphere.radius_m = tool.radius_m;
      sphere.body = static_cast<int>(world.bodies.size() + hand);
      sphere.rigid = rigid;
      sphere.local_m = tool.position_m;
      sphere.is_tool = true;
      sphere.tool_slip_speed_m_s = hands[hand].tool_slip_speed_m_s;
      described.description.spheres.push_back(sphere);
    }
  }
}

void add_sleepers(const bodies::World& world, DescribedWorld& described) {
  for (const bodies::BodyRange& body : world.bodies) {
    const double speed_m_s = rest_speed_m_s(world, body);
    described.sleeper_of_body.push_back(-1);
    if (speed_m_s == 0.0) continue;
    described.sleeper_of_body.back() = static_cast<int>(described.description.bodies.size());
    const double bounding_radius_m =
        body.rigid < 0 ? 0.0
                       : world.rigid_bodies[static_cast<std::size_t>(body.rigid)].bounding_radius_m;
    described.description.bodies.push_back(
        {body.first_node, body.node_count, body.rigid, speed_m_s, bounding_radius_m});
  }
}

}  // namespace

double rest_speed_m_s(const bodies::World& world, const bodies::BodyRange& body) {
  constexpr double kRestRadii_s = 0.03, kRestSlip = 0.2;
  const bool is_free =
      body.node_count > 0 ||
      (body.rigid >= 0 && world.rigid_bodies[static_cast<std::size_t>(body.rigid)].free);
  if (!is_free || body.sphere_count == 0) return 0.0;
  double speed_m_s = std::numeric_limits<double>::max();
  for (int i = body.first_sphere; i < body.first_sphere + body.sphere_count; ++i) {
    const bodies::SphereBinding& sphere = world.spheres[static_cast<std::size_t>(i)];
    const auto material = static_cast<std::size_t>(sphere.material);
    speed_m_s = std::min(speed_m_s, kRestSlip * world.materials[material].slip_speed_m_s);
    // A point's radius does not depend on its body's size.
    if (!sphere.is_field_point) speed_m_s = std::min(speed_m_s, kRestRadii_s * sphere.radius_m);
  }
  for (const bodies::FieldBody& field : world.fields)
    if (&world.bodies[static_cast<std::size_t>(field.body)] == &body)
      speed_m_s = std::min(speed_m_s, kRestRadii_s * collision::detail_m(field.field->shape()));
  return speed_m_s;
}

DescribedWorld described_without_spheres(const bodies::World& world) {
  DescribedWorld described;
  described.description.gravity_m_s2 = world.gravity_m_s2;
  described.description.materials = world.materials;
  if (world.materials.empty()) described.description.materials.emplace_back();
  add_deformable(world, described);
  for (const bodies::RigidBody& body : world.rigid_bodies) {
    const int rigid = add_rigid(body, described);
    if (body.free) continue;
    described.prescribed.push_back(static_cast<std::size_t>(rigid));
    described.description.rigid_bodies.back().is_fixture = !body.prescribed.moves();
  }
  return described;
}

SceneModel model_of(DescribedWorld described, const bodies::World& world) {
  SceneModel model;
  model.description = std::move(described.description);
  model.start = std::move(described.state);
  model.has_static_body = described.has_static_body;
  model.hands = described.hands;
  for (const std::size_t r : described.prescribed)
    model.prescribed.push_back(world.rigid_bodies[r].prescribed);
  return model;
}

DescribedWorld described(const bodies::World& world, std::span<const scene::Hand> hands,
                         bool may_sleep) {
  DescribedWorld described = described_without_spheres(world);
  add_moving_spheres(world, described);
  add_static(world, described);
  add_tools(world, hands, described);
  described.description.apart_spheres = contact::SelfCollision(world).apart_spheres(world);
  if (may_sleep) add_sleepers(world, described);
  described.description.apart = bodies_apart(world);
  return described;
}

}  // namespace stillgrid::dynamics
