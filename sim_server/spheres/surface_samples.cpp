#include "sim_server/spheres/surface_samples.hpp"

#include <Eigen/Geometry>
#include <cassert>
#include <cmath>

namespace stillgrid::spheres {
namespace {

/// Twice the area, along the normal.
Eigen::Vector3d area_vector_m2(const mesh::TriangleMesh& mesh, const Eigen::Vector3i& triangle) {
  const auto corner_m = [&](int i) -> const Eigen::Vector3d& {
    return mesh.vertices_m[static_cast<std::size_t>(triangle[i])];
  };
  return (corner_m(1) - corner_m(0)).cross(corner_m(2) - corner_m(0));
}

/// The i-th place of a triangle: Roberts' recurrence of the plastic number over the unit square,
/// whose upper half is folded onto the lower.
Eigen::Vector3d barycentric(std::size_t i) {
  constexpr double kPlastic = 1.32471795724474602596;
  const double n = static_cast<double>(i + 1);
  double u = std::fmod(n / kPlastic, 1.0);
  double v = std::fmod(n / (kPlastic * kPlastic), 1.0);
  if (u + v > 1.0) {
    u = 1.0 - u;
    v = 1.0 - v;
  }
  return {1.0 - u - v, u, v};
}

}  // namespace

SurfaceSamples sample_surface(const mesh::TriangleMesh& mesh, std::size_t count) {
  double whole_m2 = 0.0;
  for (const Eigen::Vector3i& triangle : mesh.triangles)
    whole_m2 += area_vector_m2(mesh, triangle).norm();
  assert(whole_m2 > 0.0 && count > 0);

  SurfaceSamples samples;
  samples.points_m.reserve(count);
  samples.normals.reserve(count);
  double passed_m2 = 0.0;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    const Eigen::Vector3d area_m2 = area_vector_m2(mesh, triangle);
    passed_m2 += area_m2.norm();
    const auto due = [&](std::size_t i) {
      return (static_cast<double>(i) + 0.5) / static_cast<double>(count) * whole_m2;
    };
    for (std::size_t i = samples.points_m.size(); i < count && due(i) < passed_m2; ++i) {
      const Eigen::Vector3d weights = barycentric(i);
      Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
      for (int corner = 0; corner < 3; ++corner)
        point_m += weights[corner] * mesh.vertices_m[static_cast<std::size_t>(triangle[corner])];
      samples.points_m.push_back(point_m);
      samples.normals.push_back(area_m2.normalized());
    }
  }
  return samples;
}

}  // namespace stillgrid::spheres
