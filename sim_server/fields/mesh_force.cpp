#include "sim_server/fields/mesh_force.hpp"

#include <cassert>
#include <cmath>

#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::fields {

Eigen::Vector3d exact_force_m(const mesh::MeshDistance& mesh, const Eigen::Vector3d& tool_m,
                              double tool_radius_m) {
  constexpr double kOnSurface_m = 1e-12;  // nearer, the way out is the surface's normal
  const double distance_m = mesh.signed_distance_m(tool_m);
  if (distance_m >= tool_radius_m) return Eigen::Vector3d::Zero();
  const mesh::NearestPoint nearest = mesh.closest(tool_m);
  const Eigen::Vector3d away_m = tool_m - nearest.point_m;
  const Eigen::Vector3d out =
      std::abs(distance_m) < kOnSurface_m ? nearest.normal : Eigen::Vector3d(away_m / distance_m);
  return (tool_radius_m - distance_m) * out;
}

PressedPlaces press_everywhere(const mesh::TriangleMesh& closed, const mesh::MeshDistance& distance,
                               std::size_t count, double tool_radius_m,
                               std::span<const double> depths_m) {
  const spheres::SurfaceSamples surface = spheres::sample_surface(closed, count);
  PressedPlaces places{.tool_radius_m = tool_radius_m, .tool_m = {}, .force_m = {}};
  for (const double depth_m : depths_m) {
    const spheres::SurfaceSamples reachable =
        spheres::reachable_samples(surface, distance, tool_radius_m, depth_m);
    for (std::size_t i = 0; i < reachable.points_m.size(); ++i) {
      places.tool_m.emplace_back(reachable.points_m[i] +
                                 (tool_radius_m - depth_m) * reachable.normals[i]);
      places.force_m.push_back(exact_force_m(distance, places.tool_m.back(), tool_radius_m));
    }
  }
  return places;
}

double force_error_share(const PressedPlaces& places, const spheres::UnitForce& force) {
  assert(!places.tool_m.empty());
  double error_m2 = 0.0, exact_m2 = 0.0;
  for (std::size_t i = 0; i < places.tool_m.size(); ++i) {
    error_m2 += (force(places.tool_m[i]) - places.force_m[i]).squaredNorm();
    exact_m2 += places.force_m[i].squaredNorm();
  }
  return std::sqrt(error_m2 / exact_m2);
}

}  // namespace stillgrid::fields
