#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"

namespace stillgrid {

/// A point of a surface as a weighted sum of sphere centres. Weights sum to one and give the point
/// at rest, so that every affine motion of the centres, a rotation too, moves it exactly along.
struct SurfacePoint {
  std::array<int, 8> spheres{};  // as published: moving ones, then static ones
  std::array<double, 8> weights{};
  int count = 0;
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

/// The surfaces of a world that was just built from that scene: of a sheet the grid of its spheres,
/// of a thread the line through them, of a box its faces, of a soft block its lattice's skin, of a
/// mesh its triangles. Planes and spheres have none, nor has a box or a mesh whose spheres span no
/// space, such as one row or one layer of them.
[[nodiscard]] std::vector<BodySurface> rest_surfaces(const SceneDescription& scene,
                                                     const World& world);

}  // namespace stillgrid
