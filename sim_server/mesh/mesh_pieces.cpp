#include "sim_server/mesh/mesh_pieces.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <unordered_map>
#include <utility>
#include <vector>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/mesh/mesh_file.hpp"

namespace stillgrid::mesh {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// One piece by itself.
struct Piece {
  TriangleMesh mesh;
  Eigen::AlignedBox3d box;
  double volume_m3 = 0.0;  // negative if it is inside out
};

double signed_volume_m3(const TriangleMesh& mesh) {
  double six_volumes = 0.0;
  const Eigen::Vector3d origin_m = mesh.vertices_m.front();
  for (const Eigen::Vector3i& t : mesh.triangles)
    six_volumes += (mesh.vertices_m[index(t[0])] - origin_m)
                       .dot((mesh.vertices_m[index(t[1])] - origin_m)
                                .cross(mesh.vertices_m[index(t[2])] - origin_m));
  return six_volumes / 6.0;
}

std::vector<Piece> parts_of(const TriangleMesh& mesh, std::span<const int> piece_of_face,
                            int count) {
  std::vector<Piece> parts(index(count));
  std::vector<std::unordered_map<int, int>> numbers(parts.size());  // of vertices, in each piece
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    realtime::throw_if_stopped();
    const std::size_t piece = index(piece_of_face[i]);
    Piece& part = parts[piece];
    Eigen::Vector3i triangle = mesh.triangles[i];
    for (int& vertex : triangle) {
      const Eigen::Vector3d& place_m = mesh.vertices_m[index(vertex)];
      const auto [known, is_new] =
          numbers[piece].try_emplace(vertex, static_cast<int>(part.mesh.vertices_m.size()));
      if (is_new) part.mesh.vertices_m.push_back(place_m);
      part.box.extend(place_m);
      vertex = known->second;
    }
    part.mesh.triangles.push_back(triangle);
  }
  return parts;
}

/// Of each piece the pieces that it lies in. They do not cut one another, so one vertex tells.
std::vector<std::vector<int>> holders_of(const std::vector<Piece>& parts) {
  std::vector<std::vector<int>> holders(parts.size());
  for (std::size_t outer = 0; outer < parts.size(); ++outer) {
    std::vector<std::size_t> candidates;
    for (std::size_t inner = 0; inner < parts.size(); ++inner)
      if (inner != outer && std::abs(parts[inner].volume_m3) < std::abs(parts[outer].volume_m3) &&
          parts[outer].box.contains(parts[inner].mesh.vertices_m.front()))
        candidates.push_back(inner);
    realtime::throw_if_stopped();
    if (candidates.empty()) continue;
    TriangleMesh outward = parts[outer].mesh;
    if (parts[outer].volume_m3 < 0.0)
      for (Eigen::Vector3i& t : outward.triangles) std::swap(t[0], t[1]);
    const MeshDistance distance(outward);
    for (const std::size_t inner : candidates)
      if (distance.signed_distance_m(parts[inner].mesh.vertices_m.front()) < 0.0)
        holders[inner].push_back(static_cast<int>(outer));
  }
  return holders;
}

}  // namespace

int turn_pieces(TriangleMesh& mesh, std::span<const int> piece_of_face, int count,
                const std::string& name) {
  if (count > kMaxPieces)
    throw NotSolid(name + ": " + std::to_string(count) + " separate pieces: expected at most " +
                   std::to_string(kMaxPieces));
  std::vector<Piece> parts = parts_of(mesh, piece_of_face, count);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i].volume_m3 = signed_volume_m3(parts[i].mesh);
    const double size_m = parts[i].box.diagonal().norm();
    if (std::abs(parts[i].volume_m3) < 1e-12 * size_m * size_m * size_m)
      throw NotSolid(name + ": piece " + std::to_string(i + 1) + " of " + std::to_string(count) +
                     ", " + std::to_string(parts[i].mesh.triangles.size()) +
                     " faces: encloses no volume: expected a solid");
  }
  const std::vector<std::vector<int>> holders = holders_of(parts);
  std::vector<char> turn(parts.size(), 0);
  int turned = 0, doubtful = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    turn[i] = holders[i].empty() && parts[i].volume_m3 < 0.0;
    for (const int holder : holders[i]) {
      // A file that is wholly inside out has its cavities turned as well.
      if (holders[index(holder)].empty()) turn[i] = parts[index(holder)].volume_m3 < 0.0;
    }
    turned += turn[i] ? 1 : 0;
    const bool is_outward = (parts[i].volume_m3 > 0.0) != static_cast<bool>(turn[i]);
    doubtful += is_outward != (holders[i].size() % 2 == 0) ? 1 : 0;
  }
  if (doubtful > 0)
    throw NotSolid(name + ": " + std::to_string(doubtful) + " of " + std::to_string(count) +
                   " pieces lie within another and face the same way: expected a cavity that "
                   "faces the other way, or no piece there");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if (turn[index(piece_of_face[i])]) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  return turned;
}

}  // namespace stillgrid::mesh
