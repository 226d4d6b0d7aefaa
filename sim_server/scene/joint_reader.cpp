#include "sim_server/scene/joint_reader.hpp"

#include <algorithm>
#include <limits>
#include <sstream>
#include <string_view>
#include <vector>

#include "sim_server/bodies/kinds/body_in_world.hpp"

namespace stillgrid::scene {
namespace {

/// A body is joined by a node that is as near as its longest spring reaches.
void require_node(toml::TableReader& table, const bodies::BodyDescription& body,
                  const std::vector<Eigen::Vector3d>& points_m) {
  if (body.motion == bodies::Motion::kStatic) return;
  const bodies::SpringNet net = bodies::spring_net_of(body);
  if (net.nodes_m.empty()) return;
  double longest_m = 0.0;
  for (const bodies::SpringNet::Link& link : net.links) {
    if (link.stiffness_N_per_m <= 0.0) continue;
    longest_m = std::max(longest_m, (net.nodes_m[static_cast<std::size_t>(link.a)] -
                                     net.nodes_m[static_cast<std::size_t>(link.b)])
                                        .norm());
  }
  for (const Eigen::Vector3d& point_m : points_m) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& node_m : net.nodes_m)
      nearest_m = std::min(nearest_m, (node_m - point_m).norm());
    if (nearest_m <= longest_m) continue;
    std::ostringstream expected;
    expected << "points within " << longest_m << " m of a node of body '" << body.name << "': ["
             << point_m.x() << ", " << point_m.y() << ", " << point_m.z() << "] is " << nearest_m
             << " m from the nearest";
    table.refuse("points_m", expected.str());
  }
}

}  // namespace

JointDescription read_joint(toml::TableReader& table,
                            std::span<const bodies::BodyDescription> bodies) {
  JointDescription joint;
  joint.name = table.name("name");
  std::vector<std::string_view> names;
  for (const bodies::BodyDescription& body : bodies) names.push_back(body.name);
  if (names.empty()) table.refuse("body", "a [[body]] of the scene, which has none");
  const auto body_of = [&](int number) -> const bodies::BodyDescription& {
    return bodies[static_cast<std::size_t>(number)];
  };
  const auto is_free = [&](int number) {
    return number >= 0 && body_of(number).motion == bodies::Motion::kFree;
  };
  joint.body_a = static_cast<int>(table.choice("body", names));
  if (table.has("joined_to")) joint.body_b = static_cast<int>(table.choice("joined_to", names));
  if (joint.body_b == joint.body_a)
    table.refuse("joined_to", "another body than body, or none: the world");
  if (!is_free(joint.body_a) && !is_free(joint.body_b))
    table.refuse("body", "a body whose motion is \"free\", as one of the two at least");
  joint.points_m = table.vectors("points_m");
  require_node(table, body_of(joint.body_a), joint.points_m);
  joint.stiffness_N_per_m = table.number("stiffness_N_per_m", toml::Bound::kPositive);
  joint.damping_N_s_per_m =
      table.number_or("damping_N_s_per_m", toml::Bound::kNotNegative, joint.damping_N_s_per_m);
  if (joint.body_b >= 0) {
    require_node(table, body_of(joint.body_b), joint.points_m);
    joint.collide = table.flag_or("collide", joint.collide);
  }
  table.finish();
  return joint;
}

}  // namespace stillgrid::scene
