#include "sim_server/bodies/kinds/packing.hpp"

#include <algorithm>
#include <cmath>

#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

constexpr double kMaxSpheresPerSide = 1000.0;

/// Edge lengths between the centres of a box's outermost spheres.
Eigen::Vector3d inner_size_m(const Eigen::Vector3d& size_m, double radius_m) {
  return (size_m.array() - 2.0 * radius_m).max(0.0).matrix();
}

}  // namespace

SpherePacking read_packing(toml::TableReader& table, double longest_side_m) {
  SpherePacking packing;
  toml::TableReader spheres = table.table("spheres");
  packing.spacing_m =
      spheres.has("spacing_m") ? spheres.number("spacing_m", toml::Bound::kPositive) : 0.0;
  packing.radius_m =
      spheres.has("radius_m") ? spheres.number("radius_m", toml::Bound::kPositive) : 0.0;
  spheres.finish();
  if (packing.spacing_m > 0.0 && longest_side_m > kMaxSpheresPerSide * packing.spacing_m) {
    spheres.refuse("spacing_m", "at least a thousandth of the body's longest side");
  }
  if (packing.spacing_m > longest_side_m)
    spheres.refuse("spacing_m", "at most the body's longest side");
  if (packing.radius_m > longest_side_m)
    spheres.refuse("radius_m", "at most the body's longest side");
  return packing;
}

SpherePacking completed(SpherePacking packing, double radius_m, double largest_radius_m) {
  if (packing.radius_m <= 0.0)
    packing.radius_m =
        packing.spacing_m > 0.0 ? std::min(packing.spacing_m, largest_radius_m) : radius_m;
  if (packing.spacing_m <= 0.0) packing.spacing_m = packing.radius_m;
  return packing;
}

SpherePacking completed_for_box(const SpherePacking& packing, const Eigen::Vector3d& size_m) {
  const double shortest_m = size_m.minCoeff();
  return completed(packing, std::min(size_m.maxCoeff() / 6.0, shortest_m / 3.0), 0.5 * shortest_m);
}

double spheres_along(double length_m, double spacing_m) {
  constexpr double kRounding = 1e-6;  // of a quotient that is meant to be whole
  return std::max(1.0, std::ceil(length_m / spacing_m - kRounding) + 1.0);
}

int count_along(double length_m, double spacing_m) {
  return static_cast<int>(spheres_along(length_m, spacing_m));
}

double spread(int i, int n, double low, double high) {
  return n > 1 ? low + (high - low) * i / (n - 1) : 0.5 * (low + high);
}

LinePoint among_nodes(int i, int spheres, int nodes) {
  const double place = spread(i, spheres, 0.0, nodes - 1.0);
  const int lower = std::clamp(static_cast<int>(std::floor(place)), 0, std::max(0, nodes - 2));
  return {lower, place - lower};
}

void bind(SphereBinding& sphere, int node, double weight) {
  if (weight == 0.0) return;
  const auto slot = static_cast<std::size_t>(sphere.node_count++);
  sphere.nodes[slot] = node;
  sphere.weights[slot] = weight;
}

std::vector<spheres::Ball> balls_of_box(const Eigen::Vector3d& size_m,
                                        const SpherePacking& packing) {
  const auto [spacing_m, radius_m] = completed_for_box(packing, size_m);
  const Eigen::Vector3d inner_m = inner_size_m(size_m, radius_m);
  Eigen::Vector3i counts;
  for (int axis = 0; axis < 3; ++axis) counts[axis] = count_along(inner_m[axis], spacing_m);
  const auto along = [&](int i, int axis) {
    return spread(i, counts[axis], -0.5, 0.5) * inner_m[axis];
  };
  std::vector<spheres::Ball> balls;
  for (int z = 0; z < counts.z(); ++z)
    for (int y = 0; y < counts.y(); ++y)
      for (int x = 0; x < counts.x(); ++x)
        balls.push_back({{along(x, 0), along(y, 1), along(z, 2)}, radius_m});
  return balls;
}

double ball_count_of_box(const Eigen::Vector3d& size_m, const SpherePacking& packing) {
  const auto [spacing_m, radius_m] = completed_for_box(packing, size_m);
  const Eigen::Vector3d inner_m = inner_size_m(size_m, radius_m);
  return spheres_along(inner_m.x(), spacing_m) * spheres_along(inner_m.y(), spacing_m) *
         spheres_along(inner_m.z(), spacing_m);
}

SphereBinding placed_sphere(const spheres::Ball& ball, const Eigen::Vector3d& position_m,
                            const Eigen::Quaterniond& orientation) {
  SphereBinding sphere;
  sphere.radius_m = ball.radius_m;
  sphere.rest_position_m = position_m + orientation * ball.centre_m;
  return sphere;
}

std::vector<SphereBinding> fixed_spheres(std::span<const spheres::Ball> balls,
                                         const Eigen::Vector3d& position_m,
                                         const Eigen::Quaterniond& orientation) {
  std::vector<SphereBinding> spheres;
  for (const spheres::Ball& ball : balls) {
    SphereBinding& sphere = spheres.emplace_back(placed_sphere(ball, position_m, orientation));
    sphere.local_m = ball.centre_m;
  }
  return spheres;
}

}  // namespace stillgrid::bodies
