#include "sim_server/mesh/mesh_holes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <unordered_map>
#include <vector>

#include "sim_server/mesh/mass_properties.hpp"

namespace stillgrid::mesh {
namespace {

/// The numbers of border edges, hole by hole; none if borders meet.
std::vector<std::vector<std::size_t>> loops_of(std::span<const Eigen::Vector2i> border) {
  std::unordered_map<int, std::vector<std::size_t>> edges_at;
  for (std::size_t i = 0; i < border.size(); ++i)
    for (const int vertex : border[i]) edges_at[vertex].push_back(i);
  if (std::ranges::any_of(edges_at, [](const auto& at) { return at.second.size() != 2; }))
    return {};
  std::vector<char> is_passed(border.size(), 0);
  std::vector<std::vector<std::size_t>> loops;
  for (std::size_t first = 0; first < border.size(); ++first) {
    if (is_passed[first]) continue;
    std::vector<std::size_t>& loop = loops.emplace_back();
    int vertex = border[first][0];
    for (std::size_t edge = first; !is_passed[edge];) {
      is_passed[edge] = 1;
      loop.push_back(edge);
      vertex = border[edge].sum() - vertex;
      const std::vector<std::size_t>& pair = edges_at[vertex];
      edge = pair[0] == edge ? pair[1] : pair[0];
    }
  }
  return loops;
}

}  // namespace

ClosedHoles close_small_holes(TriangleMesh& mesh, std::span<const Eigen::Vector2i> border) {
  const auto at = [&](int vertex) -> const Eigen::Vector3d& {
    return mesh.vertices_m[static_cast<std::size_t>(vertex)];
  };
  ClosedHoles holes;
  TriangleMesh lids;
  double large_m2 = 0.0;
  for (const std::vector<std::size_t>& loop : loops_of(border)) {
    const int middle = static_cast<int>(mesh.vertices_m.size() + lids.vertices_m.size());
    Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
    for (const std::size_t edge : loop)
      middle_m +=
          0.5 / static_cast<double>(loop.size()) * (at(border[edge][0]) + at(border[edge][1]));
    double length_m = 0.0;
    for (const std::size_t edge : loop) {
      const Eigen::Vector3d &from_m = at(border[edge][0]), &to_m = at(border[edge][1]);
      length_m += (to_m - from_m).norm();
      if (loop.size() > 3) large_m2 += 0.5 * (from_m - middle_m).cross(to_m - middle_m).norm();
      lids.triangles.push_back({border[edge][1], border[edge][0], middle});
    }
    lids.vertices_m.push_back(middle_m);
    ++holes.count;
    holes.longest_border_m = std::max(holes.longest_border_m, length_m);
  }
  if (large_m2 > kSmallHoles * surface_area_m2(mesh)) return {};
  mesh.vertices_m.insert(mesh.vertices_m.end(), lids.vertices_m.begin(), lids.vertices_m.end());
  mesh.triangles.insert(mesh.triangles.end(), lids.triangles.begin(), lids.triangles.end());
  return holes;
}

}  // namespace stillgrid::mesh
