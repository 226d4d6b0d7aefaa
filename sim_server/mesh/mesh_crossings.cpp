#include "sim_server/mesh/mesh_crossings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/mesh/mesh_file.hpp"

namespace stillgrid::mesh {
namespace {

/// Six volumes of the tetrahedron, signed.
double turn(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
            const Eigen::Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool pierces(const TriangleMesh& mesh, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
             const Eigen::Vector3i& triangle, bool at_its_edges_too) {
  const auto corner = [&](int i) -> const Eigen::Vector3d& {
    return mesh.vertices_m[static_cast<std::size_t>(triangle[i])];
  };
  const double above = turn(corner(0), corner(1), corner(2), p);
  const double below = turn(corner(0), corner(1), corner(2), q);
  // Rounding must not make a crossing of what lies in one plane.
  const double size_m = std::max({(q - p).norm(), (corner(1) - corner(0)).norm(),
                                  (corner(2) - corner(1)).norm(), (corner(0) - corner(2)).norm()});
  const double slack_m3 = 1e-11 * size_m * size_m * size_m;
  if (!(above * below < 0.0) || std::min(std::abs(above), std::abs(below)) <= slack_m3)
    return false;
  const double first = turn(p, q, corner(0), corner(1));
  const double second = turn(p, q, corner(1), corner(2));
  const double third = turn(p, q, corner(2), corner(0));
  const double least = std::min({first, second, third}), most = std::max({first, second, third});
  const double edge_m3 = at_its_edges_too ? -slack_m3 : 0.0;
  return least > edge_m3 || most < -edge_m3;
}

}  // namespace

Crossings count_crossings(const TriangleMesh& mesh, std::span<const int> piece_of_face,
                          const std::string& name) {
  constexpr std::size_t kMaxPairs = 500'000'000;
  const MeshDistance surface(mesh);
  std::size_t pairs = 0;
  Crossings crossings;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
      if (a > b) continue;  // the face beyond has it the other way round
      const Eigen::Vector3d& p = mesh.vertices_m[static_cast<std::size_t>(a)];
      const Eigen::Vector3d& q = mesh.vertices_m[static_cast<std::size_t>(b)];
      const std::vector<int> near = surface.triangles_near(0.5 * (p + q), 0.5 * (q - p).norm());
      pairs += near.size();
      if (pairs > kMaxPairs)
        throw MeshError(name + ": " + std::to_string(mesh.triangles.size()) +
                        " triangles, so many of them long and near one another that what cuts "
                        "itself cannot be told: expected shorter edges");
      for (const int other : near) {
        const auto j = static_cast<std::size_t>(other);
        const Eigen::Vector3i& face = mesh.triangles[j];
        if ((face.array() == a).any() || (face.array() == b).any()) continue;
        const bool is_own = piece_of_face[i] == piece_of_face[j];
        if (!pierces(mesh, p, q, face, is_own)) continue;
        ++(is_own ? crossings.within_pieces : crossings.between_pieces);
      }
    }
  return crossings;
}

}  // namespace stillgrid::mesh
