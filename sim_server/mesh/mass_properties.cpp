#include "sim_server/mesh/mass_properties.hpp"

#include <Eigen/Geometry>

namespace stillgrid::mesh {

MassProperties mass_properties(const TriangleMesh& closed) {
  // From a corner of the mesh: far from the origin the differences would cancel.
  const Eigen::Vector3d origin_m = closed.vertices_m.front();
  double volume = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3i& triangle : closed.triangles) {
    const auto corner = [&](int i) -> Eigen::Vector3d {
      return closed.vertices_m[static_cast<std::size_t>(triangle[i])] - origin_m;
    };
    const Eigen::Vector3d a = corner(0), b = corner(1), c = corner(2), sum = a + b + c;
    const double tetrahedron = a.dot(b.cross(c)) / 6.0;
    volume += tetrahedron;
    first += tetrahedron / 4.0 * sum;
    second += tetrahedron / 20.0 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  MassProperties properties;
  properties.volume_m3 = volume;
  const Eigen::Vector3d centre = first / volume;
  properties.centre_m = origin_m + centre;
  const Eigen::Matrix3d central = second / volume - centre * centre.transpose();
  properties.inverse_inertia_per_kg_m2 = central.trace() * Eigen::Matrix3d::Identity() - central;
  return properties;
}

double surface_area_m2(const TriangleMesh& mesh) {
  double area_m2 = 0.0;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    const auto corner = [&](int i) -> const Eigen::Vector3d& {
      return mesh.vertices_m[static_cast<std::size_t>(triangle[i])];
    };
    area_m2 += 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
  }
  return area_m2;
}

}  // namespace stillgrid::mesh
