#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::bodies {

/// A point of a surface as a weighted sum of sphere centres. Weights sum to one and give the point
/// at rest, so that every affine motion of the centres, a rotation too, moves it exactly along. Of
/// a body that has no spheres and never moves: a place.
struct SurfacePoint {
  std::array<int, 8> spheres{};  // as published: moving ones, then static ones
  std::array<double, 8> weights{};
  int count = 0;
  Eigen::Vector3d still_m = Eigen::Vector3d::Zero();  // world frame; where count is 0
};

/// What a body looks like, for a display: triangles, or lines.
struct BodySurface {
  int body = 0;  // order in the scene file
  std::vector<SurfacePoint> vertices;
  std::vector<Eigen::Vector3i> triangles;  // counter-clockwise seen from outside
  std::vector<Eigen::Vector2i> lines;
};

/// A point by the weights of the least norm over eight spheres near it; nothing unless the spheres
/// span space. Sets of eight that lie too flat for their place are passed over for wider ones.
/// first: the number of the first sphere.
[[nodiscard]] std::optional<SurfacePoint> bind_to_spheres(
    std::span<const Eigen::Vector3d> centres_m, int first, const Eigen::Vector3d& point_m);

/// The spheres of a body where it rests, and their first number.
struct RestSpheres {
  std::vector<Eigen::Vector3d> centres_m;
  int first = 0;
};
/// Of a world that was just built. body: its number there.
[[nodiscard]] RestSpheres rest_spheres(const World& world, int body);

/// A mesh of a body that stands there, bound to its spheres; without vertices where they span no
/// space.
[[nodiscard]] BodySurface bound_surface(const mesh::TriangleMesh& mesh,
                                        const Eigen::Vector3d& position_m,
                                        const Eigen::Quaterniond& orientation,
                                        const RestSpheres& spheres);

/// A mesh of a body that stands there for ever, bound to nothing.
[[nodiscard]] BodySurface still_surface(const mesh::TriangleMesh& mesh,
                                        const Eigen::Vector3d& position_m,
                                        const Eigen::Quaterniond& orientation);

/// The spheres themselves, joined along rows and columns.
[[nodiscard]] BodySurface grid_surface(const RestSpheres& spheres, int columns);

/// Adds a face of four corners as two triangles.
void add_quad(mesh::TriangleMesh& mesh, int a, int b, int c, int d);

}  // namespace stillgrid::bodies
