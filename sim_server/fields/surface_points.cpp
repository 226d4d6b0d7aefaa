#include "sim_server/fields/surface_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::fields {
namespace {

using Eigen::Vector3d;

/// Of a ball's radius to the spacing: small, for its point is what counts.
constexpr double kRadiusShare = 0.02;
/// A corner that lacks less than this of a full turn, rad, or an edge that bends less, is as good
/// as flat.
constexpr double kSharp_rad = 0.3;
/// Discs whose middles are a spacing apart cover at most so much of a plane, in squares of it.
constexpr double kDensest = 2.0 / std::numbers::sqrt3;

struct Point {
  Vector3d place_m, normal;
};

/// Keeps points that are no nearer than a spacing to one on their side that was kept before.
class Spread {
 public:
  Spread(double spacing_m, std::vector<Point>& kept) : spacing_m_(spacing_m), kept_(kept) {}

  void offer(const Point& point) {
    const auto cell = [&](int axis) {
      return static_cast<std::int64_t>(std::floor(point.place_m[axis] / spacing_m_));
    };
    const Cell own = {cell(0), cell(1), cell(2)};
    for (int n = 0; n < 27; ++n) {
      const auto found =
          cells_.find({own[0] + n % 3 - 1, own[1] + n / 3 % 3 - 1, own[2] + n / 9 - 1});
      if (found == cells_.end()) continue;
      for (const std::size_t i : found->second)
        if ((kept_[i].place_m - point.place_m).squaredNorm() < spacing_m_ * spacing_m_ &&
            kept_[i].normal.dot(point.normal) > 0.0)
          return;
    }
    cells_[own].push_back(kept_.size());
    kept_.push_back(point);
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  double spacing_m_;
  std::vector<Point>& kept_;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

const Vector3d& corner_m(const mesh::TriangleMesh& mesh, std::size_t triangle, int corner) {
  return mesh.vertices_m[static_cast<std::size_t>(mesh.triangles[triangle][corner % 3])];
}

Vector3d normal_of(const mesh::TriangleMesh& mesh, std::size_t triangle) {
  const Vector3d& a = corner_m(mesh, triangle, 0);
  return (corner_m(mesh, triangle, 1) - a).cross(corner_m(mesh, triangle, 2) - a).normalized();
}

/// Vertices that stick out, the sharpest first.
std::vector<std::size_t> sharp_vertices(const mesh::TriangleMesh& mesh) {
  std::vector<double> lacks_rad(mesh.vertices_m.size(), 2.0 * std::numbers::pi);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const Vector3d u = corner_m(mesh, i, k + 1) - corner_m(mesh, i, k),
                     v = corner_m(mesh, i, k + 2) - corner_m(mesh, i, k);
      lacks_rad[static_cast<std::size_t>(mesh.triangles[i][k])] -=
          std::atan2(u.cross(v).norm(), u.dot(v));
    }
  std::vector<std::size_t> sharp;
  for (std::size_t i = 0; i < lacks_rad.size(); ++i)
    if (lacks_rad[i] > kSharp_rad) sharp.push_back(i);
  std::stable_sort(sharp.begin(), sharp.end(),
                   [&](std::size_t a, std::size_t b) { return lacks_rad[a] > lacks_rad[b]; });
  return sharp;
}

/// The ends of edges whose faces bend away from each other.
std::vector<std::pair<Vector3d, Vector3d>> sharp_edges(const mesh::TriangleMesh& mesh) {
  std::map<std::pair<int, int>, std::size_t> other_side;  // of an edge, the triangle met first
  std::vector<std::pair<Vector3d, Vector3d>> edges;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const auto ends = std::minmax(mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3]);
      const auto [found, is_new] = other_side.try_emplace({ends.first, ends.second}, i);
      if (is_new) continue;
      const Vector3d here = normal_of(mesh, i), there = normal_of(mesh, found->second);
      const Vector3d along = corner_m(mesh, i, k + 1) - corner_m(mesh, i, k);
      if (std::atan2(here.cross(there).dot(along.normalized()), here.dot(there)) > kSharp_rad)
        edges.emplace_back(corner_m(mesh, i, k), corner_m(mesh, i, k + 1));
    }
  return edges;
}

}  // namespace

std::vector<spheres::Ball> surface_points(const mesh::TriangleMesh& closed, std::size_t most) {
  constexpr double kSamplesASpacing = 24.0;  // per square of the spacing: so gaps stay small
  const double area_m2 = mesh::surface_area_m2(closed);
  const double spacing_m = std::sqrt(kDensest * area_m2 / static_cast<double>(most));
  const mesh::MeshDistance distance(closed);
  std::vector<Point> points;
  Spread spread(spacing_m, points);
  const auto offer = [&](const Vector3d& place_m) {
    spread.offer({place_m, distance.closest(place_m).normal});
  };
  for (const std::size_t vertex : sharp_vertices(closed)) offer(closed.vertices_m[vertex]);
  for (const auto& [from_m, to_m] : sharp_edges(closed)) {
    const double parts = std::ceil((to_m - from_m).norm() / spacing_m);
    for (double i = 1.0; i < parts; ++i) offer(from_m + i / parts * (to_m - from_m));
  }
  const auto count = static_cast<std::size_t>(kSamplesASpacing * area_m2 / (spacing_m * spacing_m));
  const spheres::SurfaceSamples samples = spheres::sample_surface(closed, count + 1);
  for (std::size_t i = 0; i < samples.points_m.size(); ++i)
    spread.offer({samples.points_m[i], samples.normals[i]});

  const double radius_m = kRadiusShare * spacing_m;
  std::vector<spheres::Ball> balls;
  for (const Point& point : points) {
    // Where a spike or a saddle is sharper than that, no way along the mean normal may lead inside.
    const Vector3d inside_m = point.place_m - radius_m * point.normal;
    const bool is_inside = distance.signed_distance_m(inside_m) < 0.0;
    balls.push_back({is_inside ? inside_m : point.place_m, radius_m});
  }
  return balls;
}

}  // namespace stillgrid::fields
