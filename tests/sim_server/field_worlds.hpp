#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "shared/collision/distance_field.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/spheres/ball.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::sim_server {

using Field = std::shared_ptr<const collision::DistanceField>;

/// Fields of solids whose distance is known, with room round them for spheres of margin_m.
[[nodiscard]] inline Field ball_field(double radius_m, double cell_m, double margin_m) {
  const Eigen::Vector3d corner_m = Eigen::Vector3d::Constant(radius_m);
  return std::make_shared<const collision::DistanceField>(
      collision::make_field({-corner_m, corner_m}, {cell_m, 4.0 * cell_m, margin_m + 4.0 * cell_m},
                            [radius_m](const Eigen::Vector3d& x) { return x.norm() - radius_m; }));
}
[[nodiscard]] inline double box_distance_m(const Eigen::Vector3d& size_m,
                                           const Eigen::Vector3d& x) {
  const Eigen::Array3d out = x.array().abs() - 0.5 * size_m.array();
  return out.max(0.0).matrix().norm() + std::min(0.0, out.maxCoeff());
}
[[nodiscard]] inline Field box_field(const Eigen::Vector3d& size_m, double cell_m, double margin_m,
                                     const collision::ScalarField& stiffness = {}) {
  return std::make_shared<const collision::DistanceField>(collision::make_field(
      {-0.5 * size_m, 0.5 * size_m}, {cell_m, 4.0 * cell_m, margin_m + 4.0 * cell_m},
      [size_m](const Eigen::Vector3d& x) { return box_distance_m(size_m, x); }, stiffness));
}

/// Points of a box's surface, inside of it by their radius: so many along each edge.
[[nodiscard]] inline std::vector<spheres::Ball> box_points(const Eigen::Vector3d& size_m, int edge,
                                                           double radius_m) {
  std::vector<spheres::Ball> points;
  const auto at = [&](int i, int axis) {
    return (size_m[axis] - 2.0 * radius_m) * (static_cast<double>(i) / (edge - 1) - 0.5);
  };
  for (int i = 0; i < edge; ++i)
    for (int j = 0; j < edge; ++j)
      for (int k = 0; k < edge; ++k)
        if (std::min({i, j, k}) == 0 || std::max({i, j, k}) == edge - 1)
          points.push_back({{at(i, 0), at(j, 1), at(k, 2)}, radius_m});
  return points;
}
/// Points of a ball's surface, evenly on a spiral.
[[nodiscard]] inline std::vector<spheres::Ball> ball_points(double ball_radius_m, int count,
                                                            double radius_m) {
  std::vector<spheres::Ball> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, flat = std::sqrt(1.0 - z * z);
    const double turn_rad = std::numbers::pi * (3.0 - std::sqrt(5.0)) * i;
    points.push_back({(ball_radius_m - radius_m) *
                          Eigen::Vector3d(flat * std::cos(turn_rad), flat * std::sin(turn_rad), z),
                      radius_m});
  }
  return points;
}

/// A rigid body of such points, its inertia that of a solid box of those sides.
[[nodiscard]] inline bodies::BodyDescription points_body(std::vector<spheres::Ball> points,
                                                         const Eigen::Vector3d& size_m,
                                                         double mass_kg,
                                                         const Eigen::Vector3d& position_m) {
  const Eigen::Vector3d s = size_m.cwiseAbs2();
  bodies::BodyDescription body =
      rigid_mesh(std::move(points),
                 Eigen::Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()) / 12.0, mass_kg);
  body.position_m = position_m;
  return body;
}

/// The spheres of a body become points of its surface, and it is met through the field.
inline void meet_by_field(bodies::World& world, int body, Field field) {
  const bodies::BodyRange& range = world.bodies[static_cast<std::size_t>(body)];
  bodies::FieldBody& own = world.fields.emplace_back();
  own.body = body;
  own.rigid = range.rigid;
  own.field = std::move(field);
  for (int i = 0; i < range.sphere_count; ++i) {
    bodies::SphereBinding& point = world.spheres[static_cast<std::size_t>(range.first_sphere + i)];
    point.is_field_point = true;
    own.material = point.material;
  }
}

/// A body that never moves and is met through its field.
inline void add_static_field(
    bodies::World& world, Field field, const Eigen::Vector3d& position_m,
    const Eigen::Quaterniond& orientation = Eigen::Quaterniond::Identity()) {
  bodies::FieldBody& own = world.fields.emplace_back();
  own.body = static_cast<int>(world.bodies.size());
  own.position_m = position_m;
  own.orientation = orientation;
  own.field = std::move(field);
  world.bodies.emplace_back().name = "field " + std::to_string(own.body);
}

}  // namespace stillgrid::sim_server
