#include "sim_server/bodies/surfaces.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "sim_server/bodies/sphere_packing.hpp"

namespace stillgrid {
namespace {

constexpr std::size_t kMostSpheres = 8;
/// Weights that add up to more without their signs would show each rounding of a centre.
constexpr double kWideEnough = 4.0;
constexpr double kExact = 1e-9;  // of the spheres' distance

using Columns = Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, kMostSpheres>;

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
  if (nearest.size() <= kMostSpheres) return {nearest.begin(), nearest.end()};
  const auto at = [&](int i) { return centres_m[static_cast<std::size_t>(i)]; };
  std::vector<int> chosen = {nearest[0]};
  std::vector<double> apart_m2(nearest.size(), std::numeric_limits<double>::infinity());
  while (chosen.size() < kMostSpheres) {
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

/// The spheres of a body where it rests, and their first number.
struct BodySpheres {
  std::vector<Eigen::Vector3d> centres_m;
  int first = 0;
};

BodySpheres spheres_of(const World& world, int body) {
  const BodyRange& range = world.bodies[static_cast<std::size_t>(body)];
  BodySpheres spheres;
  spheres.first = range.first_sphere;
  for (int i = 0; i < range.sphere_count; ++i)
    spheres.centres_m.push_back(
        world.spheres[static_cast<std::size_t>(range.first_sphere + i)].rest_position_m);
  for (std::size_t i = 0; i < world.still_spheres.size(); ++i) {
    if (world.still_spheres[i].body != body) continue;
    if (spheres.centres_m.empty()) spheres.first = static_cast<int>(world.spheres.size() + i);
    spheres.centres_m.push_back(world.still_spheres[i].position_m);
  }
  return spheres;
}

/// A triangle mesh in the world, bound to the spheres; without vertices where they span no space.
BodySurface bound(const TriangleMesh& mesh, const BodyDescription& body,
                  const BodySpheres& spheres) {
  BodySurface surface;
  for (const Eigen::Vector3d& vertex_m : mesh.vertices_m) {
    const auto point = bind_to_spheres(spheres.centres_m, spheres.first,
                                       body.position_m + body.orientation * vertex_m);
    if (!point) return {};
    surface.vertices.push_back(*point);
  }
  surface.triangles = mesh.triangles;
  return surface;
}

void add_quad(TriangleMesh& mesh, int a, int b, int c, int d) {
  mesh.triangles.emplace_back(a, b, c);
  mesh.triangles.emplace_back(a, c, d);
}

/// In the body's frame; vertex x + 2 y + 4 z.
TriangleMesh box_mesh(const Eigen::Vector3d& size_m) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    mesh.vertices_m.emplace_back(((corner & 1) - 0.5) * size_m.x(),
                                 ((corner >> 1 & 1) - 0.5) * size_m.y(),
                                 ((corner >> 2) - 0.5) * size_m.z());
  add_quad(mesh, 0, 2, 3, 1);
  add_quad(mesh, 4, 5, 7, 6);
  add_quad(mesh, 0, 1, 5, 4);
  add_quad(mesh, 2, 6, 7, 3);
  add_quad(mesh, 0, 4, 6, 2);
  add_quad(mesh, 1, 3, 7, 5);
  return mesh;
}

/// The faces between a filled cell and none.
TriangleMesh skin_of(const SoftLattice& lattice) {
  TriangleMesh skin;
  std::vector<int> vertex_at(lattice.node_at.size(), -1);
  const Eigen::Vector3i places = lattice.cells + Eigen::Vector3i::Ones();
  const auto vertex = [&](const Eigen::Vector3i& place) {
    const auto at =
        static_cast<std::size_t>(place.x() + places.x() * (place.y() + places.y() * place.z()));
    if (vertex_at[at] < 0) {
      vertex_at[at] = static_cast<int>(skin.vertices_m.size());
      skin.vertices_m.push_back(lattice.nodes_m[static_cast<std::size_t>(lattice.node_at[at])]);
    }
    return vertex_at[at];
  };
  const auto is_filled = [&](const Eigen::Vector3i& cell) {
    if ((cell.array() < 0).any() || (cell.array() >= lattice.cells.array()).any()) return false;
    const int at = cell.x() + lattice.cells.x() * (cell.y() + lattice.cells.y() * cell.z());
    return lattice.is_filled[static_cast<std::size_t>(at)] != 0;
  };
  const auto add_faces = [&](const Eigen::Vector3i& cell) {
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        const Eigen::Vector3i out = side * Eigen::Vector3i::Unit(axis);
        if (is_filled(cell + out)) continue;
        // Turned so that the second edge is counter-clockwise from the first seen from outside.
        const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + (side > 0 ? 1 : 2)) % 3);
        const Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + (side > 0 ? 2 : 1)) % 3);
        const Eigen::Vector3i corner = cell + (side > 0 ? out : Eigen::Vector3i::Zero());
        add_quad(skin, vertex(corner), vertex(corner + u), vertex(corner + u + v),
                 vertex(corner + v));
      }
  };
  for (int z = 0; z < lattice.cells.z(); ++z)
    for (int y = 0; y < lattice.cells.y(); ++y)
      for (int x = 0; x < lattice.cells.x(); ++x)
        if (is_filled({x, y, z})) add_faces({x, y, z});
  return skin;
}

/// Its own spheres, joined along rows and columns.
BodySurface grid_surface(const BodySpheres& spheres, int columns) {
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

BodySurface surface_of(const BodyDescription& body, const BodySpheres& spheres) {
  switch (body.kind) {
    case BodyKind::kSheet:
      return grid_surface(spheres, sheet_spheres(body).x());
    case BodyKind::kThread:
      return grid_surface(spheres, 1);
    case BodyKind::kRigidBox:
      return bound(box_mesh(body.size_m), body, spheres);
    case BodyKind::kSoftBlock:
      return bound(skin_of(body.lattice), body, spheres);
    case BodyKind::kMesh:
      return bound(body.surface, body, spheres);
    case BodyKind::kSphere:
    case BodyKind::kPlane:
      break;
  }
  return {};
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
  for (std::size_t within = kMostSpheres; best_sum > kWideEnough; within *= 2) {
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

std::vector<BodySurface> rest_surfaces(const SceneDescription& scene, const World& world) {
  std::vector<BodySurface> surfaces;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyDescription& body = scene.bodies[i];
    const int number = static_cast<int>(i);
    BodySurface surface = surface_of(body, spheres_of(world, number));
    surface.body = number;
    if (!surface.vertices.empty()) surfaces.push_back(std::move(surface));
  }
  return surfaces;
}

}  // namespace stillgrid
