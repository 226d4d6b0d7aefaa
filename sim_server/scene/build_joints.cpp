#include "sim_server/scene/build_joints.hpp"

#include <algorithm>
#include <utility>

namespace stillgrid::scene {
namespace {

int nearest_node(const bodies::World& world, const bodies::BodyRange& range,
                 const Eigen::Vector3d& point_m) {
  const auto first = world.nodes.begin() + range.first_node;
  const auto nearest = std::ranges::min_element(
      first, first + range.node_count, {},
      [&](const bodies::Node& node) { return (node.position_m - point_m).squaredNorm(); });
  return static_cast<int>(nearest - world.nodes.begin());
}

/// The end of what has no nodes, at a place of the world.
bodies::JointEnd end_at(const bodies::World& world, int body, const Eigen::Vector3d& place_m) {
  bodies::JointEnd end{.body = body, .point_m = place_m};
  if (body < 0) return end;
  end.rigid = world.bodies[static_cast<std::size_t>(body)].rigid;
  if (end.rigid < 0) return end;
  const bodies::RigidBody& rigid = world.rigid_bodies[static_cast<std::size_t>(end.rigid)];
  end.point_m = rigid.orientation.conjugate() * (place_m - rigid.position_m);
  return end;
}

bodies::Joint joint_at(const bodies::World& world, const JointDescription& description,
                       const Eigen::Vector3d& point_m) {
  int body_a = description.body_a, body_b = description.body_b;
  const auto has_nodes = [&](int body) {
    return body >= 0 && world.bodies[static_cast<std::size_t>(body)].node_count > 0;
  };
  if (!has_nodes(body_a)) std::swap(body_a, body_b);
  bodies::Joint joint{.stiffness_N_per_m = description.stiffness_N_per_m,
                      .damping_N_s_per_m = description.damping_N_s_per_m};
  if (!has_nodes(body_a)) {
    joint.a = end_at(world, description.body_a, point_m);
    joint.b = end_at(world, description.body_b, point_m);
    return joint;
  }
  const auto node_of = [&](int body) {
    return nearest_node(world, world.bodies[static_cast<std::size_t>(body)], point_m);
  };
  const auto place_m = [&](int node) {
    return world.nodes[static_cast<std::size_t>(node)].position_m;
  };
  joint.a = {.body = body_a, .node = node_of(body_a)};
  joint.b = end_at(world, body_b, place_m(joint.a.node));
  if (!has_nodes(body_b)) return joint;
  joint.b = {.body = body_b, .node = node_of(body_b)};
  joint.rest_length_m = (place_m(joint.a.node) - place_m(joint.b.node)).norm();
  return joint;
}

}  // namespace

void build_joints(std::span<const JointDescription> joints, bodies::World& world) {
  for (const JointDescription& joint : joints) {
    for (const Eigen::Vector3d& point_m : joint.points_m)
      world.joints.push_back(joint_at(world, joint, point_m));
    if (joint.collide || joint.body_b < 0) continue;
    world.apart.emplace_back(joint.body_a, joint.body_b);
    world.apart.emplace_back(joint.body_b, joint.body_a);
  }
  std::ranges::sort(world.apart);
}

}  // namespace stillgrid::scene
