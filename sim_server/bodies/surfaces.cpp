#include "sim_server/bodies/surfaces.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace stillgrid::bodies {
namespace {

constexpr std::size_t kMaxSpheres = 8;
/// Weights that add up to more without their signs would show each rounding of a centre.
constexpr double kWideEnough = 4.0;
constexpr double kExact = 1e-9;  // of the spheres' distance

using Columns = Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, kMaxSpheres>;

/// The weights w of the least norm with sum w = 1 and sum w (c - p) = 0, by the normal equations of
/// the smaller side; empty where there are none.
std::vector<double> least_weights(std::span<const Eigen::Vector3d> centres_m,
                                  std::span<const int> chosen, const Eigen::Vector3d& point_m) {
  double farthest_m = 0.0;
  for (const int i : chosen)
    farthest_m = std::max(farthest_m, (centres_m[static_cast<std::size_t>(i)] - point_m).norm());
  Columns a(4, static_cast<Eigen::Index>(chosen.size()));
  for (std::size_t k = 0; k < chosen.size(); ++k)
    a.col(static_cast<Eigen::Index>(k))
        << (centres_m[static_cast<std::size_t>(chosen[k])] - point_m) / farthest_m,
        1.0;
  const Eigen::Matrix4d normal = a * a.transpose();
  const Eigen::LDLT<Eigen::Matrix4d> solver(normal);
  Eigen::Vector4d multiplier = solver.solve(Eigen::Vector4d::UnitW());
  Eigen::VectorXd weights = a.transpose() * multiplier;
  // Once more on what is left: the normal equations square the condition.
  multiplier += solver.solve(Eigen::Vector4d::UnitW() - a * weights);
  weights = a.transpose() * multiplier;
  const double error = (a * weights - Eigen::Vector4d::UnitW()).norm();
  if (!(error < kExact)) return {};
  return {weights.begin(), weights.end()};
}

/// Of numbers in the order of their distance, the first and those farthest from all before.
std::vector<int> spread_out(std::span<const Eigen::Vector3d> centres_m,
                            std::span<const int> nearest) {
  if (nearest.size() <= kMaxSpheres) return {nearest.begin(), nearest.end()};
  const auto at = [&](int i) { return centres_m[static_cast<std::size_t>(i)]; };
  std::vector<int> chosen = {nearest[0]};
  std::vector<double> apart_m2(nearest.size(), std::numeric_limits<double>::infinity());
  while (chosen.size() < kMaxSpheres) {
    for (std::size_t i = 0; i < nearest.size(); ++i)
      apart_m2[i] = std::min(apart_m2[i], (at(nearest[i]) - at(chosen.back())).squaredNorm());
    const auto farthest = std::max_element(apart_m2.begin(), apart_m2.end()) - apart_m2.begin();
    chosen.push_back(nearest[static_cast<std::size_t>(farthest)]);
  }
  return chosen;
}

SurfacePoint at_sphere(int number) {
  SurfacePoint point;
  point.spheres[0] = number;
  point.weights[0] = 1.0;
  point.count = 1;
  return point;
}

}  // namespace

std::optional<SurfacePoint> bind_to_spheres(std::span<const Eigen::Vector3d> centres_m, int first,
                                            const Eigen::Vector3d& point_m) {
  std::vector<int> order(centres_m.size());
  std::iota(order.begin(), order.end(), 0);
  const auto is_nearer = [&](int a, int b) {
    return (centres_m[static_cast<std::size_t>(a)] - point_m).squaredNorm() <
           (centres_m[static_cast<std::size_t>(b)] - point_m).squaredNorm();
  };
  std::vector<int> best;
  std::vector<double> best_weights;
  double best_sum = std::numeric_limits<double>::infinity();
  for (std::size_t within = kMaxSpheres; best_sum > kWideEnough; within *= 2) {
    const std::size_t count = std::min(within, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                      order.end(), is_nearer);
    const auto chosen = spread_out(centres_m, std::span(order).first(count));
    const auto weights =
        chosen.size() < 4 ? std::vector<double>() : least_weights(centres_m, chosen, point_m);
    double sum = weights.empty() ? std::numeric_limits<double>::infinity() : 0.0;
    for (const double weight : weights) sum += std::abs(weight);
    if (sum < best_sum) {
      best = chosen;
      best_weights = weights;
      best_sum = sum;
    }
    if (count == order.size()) break;
  }
  if (best.empty()) return std::nullopt;
  SurfacePoint point;
  for (std::size_t i = 0; i < best.size(); ++i) {
    point.spheres[i] = first + best[i];
    point.weights[i] = best_weights[i];
  }
  point.count = static_cast<int>(best.size());
  return point;
}

RestSpheres rest_spheres(const World& world, int body) {
  const BodyRange& range = world.bodies[static_cast<std::size_t>(body)];
  RestSpheres spheres;
  spheres.first = range.first_sphere;
  for (int i = 0; i < range.sphere_count; ++i)
    spheres.centres_m.push_back(
        world.spheres[static_cast<std::size_t>(range.first_sphere + i)].rest_position_m);
  for (std::size_t i = 0; i < world.static_spheres.size(); ++i) {
    if (world.static_spheres[i].body != body) continue;
    if (spheres.centres_m.empty()) spheres.first = static_cast<int>(world.spheres.size() + i);
    spheres.centres_m.push_back(world.static_spheres[i].position_m);
  }
  return spheres;
}

BodySurface bound_surface(const mesh::TriangleMesh& mesh, const Eigen::Vector3d& position_m,
                          const Eigen::Quaterniond& orientation, const RestSpheres& spheres) {
  BodySurface surface;
  for (const Eigen::Vector3d& vertex_m : mesh.vertices_m) {
    const auto point =
        bind_to_spheres(spheres.centres_m, spheres.first, position_m + orientation * vertex_m);
    if (!point) return {};
    surface.vertices.push_back(*point);
  }
  surface.triangles = mesh.triangles;
  return surface;
}

BodySurface still_surface(const mesh::TriangleMesh& mesh, const Eigen::Vector3d& position_m,
                          const Eigen::Quaterniond& orientation) {
  BodySurface surface;
  for (const Eigen::Vector3d& vertex_m : mesh.vertices_m)
    surface.vertices.emplace_back().still_m = position_m + orientation * vertex_m;
  surface.triangles = mesh.triangles;
  return surface;
}

void add_quad(mesh::TriangleMesh& mesh, int a, int b, int c, int d) {
  mesh.triangles.emplace_back(a, b, c);
  mesh.triangles.emplace_back(a, c, d);
}

BodySurface grid_surface(const RestSpheres& spheres, int columns) {
  BodySurface surface;
  const int count = static_cast<int>(spheres.centres_m.size()), rows = count / columns;
  for (int i = 0; i < count; ++i) surface.vertices.push_back(at_sphere(spheres.first + i));
  if (columns < 2 || rows < 2) {
    for (int i = 0; i + 1 < count; ++i) surface.lines.emplace_back(i, i + 1);
    return surface;
  }
  for (int y = 0; y + 1 < rows; ++y)
    for (int x = 0; x + 1 < columns; ++x) {
      const int corner = x + columns * y;
      surface.triangles.emplace_back(corner, corner + 1, corner + columns + 1);
      surface.triangles.emplace_back(corner, corner + columns + 1, corner + columns);
    }
  return surface;
}

}  // namespace stillgrid::bodies
