#include "sim_server/mesh/mass_properties.hpp"

#include <Eigen/Geometry>

namespace stillgrid::mesh {

namespace {

/// Sums the simplices of each triangle's corners, and of one point if `Corners` is 4; size() is
/// the volume or the area of one.
template <int Corners, class Size>
MassProperties properties_of(const TriangleMesh& mesh, Size&& size) {
  // From a corner of the mesh: far from the origin the differences would cancel.
  const Eigen::Vector3d origin_m = mesh.vertices_m[static_cast<std::size_t>(mesh.triangles[0][0])];
  double whole = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    const auto corner = [&](int i) -> Eigen::Vector3d {
      return mesh.vertices_m[static_cast<std::size_t>(triangle[i])] - origin_m;
    };
    const Eigen::Vector3d a = corner(0), b = corner(1), c = corner(2), sum = a + b + c;
    const double part = size(a, b, c);
    whole += part;
    first += part / Corners * sum;
    second += part / (Corners * (Corners + 1)) *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  MassProperties properties;
  const Eigen::Vector3d centre = first / whole;
  properties.centre_m = origin_m + centre;
  const Eigen::Matrix3d central = second / whole - centre * centre.transpose();
  properties.inertia_per_kg_m2 = central.trace() * Eigen::Matrix3d::Identity() - central;
  properties.volume_m3 = Corners == 4 ? whole : 0.0;
  return properties;
}

}  // namespace

MassProperties mass_properties(const TriangleMesh& closed) {
  return properties_of<4>(
      closed, [](const auto& a, const auto& b, const auto& c) { return a.dot(b.cross(c)) / 6.0; });
}

MassProperties shell_mass_properties(const TriangleMesh& mesh) {
  return properties_of<3>(mesh, [](const auto& a, const auto& b, const auto& c) {
    return 0.5 * (b - a).cross(c - a).norm();
  });
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
