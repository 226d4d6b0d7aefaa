#include "sim_server/mesh/mesh_repair.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <string>
#include <unordered_map>
#include <vector>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/mesh/mesh_crossings.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_holes.hpp"
#include "sim_server/mesh/mesh_pieces.hpp"

namespace stillgrid::mesh {
namespace {

constexpr double kWeldShare = 1e-6;  // of the box's diagonal

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// One edge of one face.
struct HalfEdge {
  int face, from, to;
};

std::pair<int, int> ends_of(const HalfEdge& edge) {
  return {std::min(edge.from, edge.to), std::max(edge.from, edge.to)};
}

/// The half edges by their two ends, equal edges one after the other.
std::vector<HalfEdge> sorted_edges(const TriangleMesh& mesh) {
  std::vector<HalfEdge> edges;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      edges.push_back({static_cast<int>(i), mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3]});
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::pair(ends_of(a), a.face) < std::pair(ends_of(b), b.face);
  });
  return edges;
}

/// Calls visit(first, count) for each set of half edges with the same ends.
template <typename Visit>
void for_each_edge(const std::vector<HalfEdge>& edges, Visit&& visit) {
  for (std::size_t first = 0, next = 0; first < edges.size(); first = next) {
    next = first + 1;
    while (next < edges.size() && ends_of(edges[next]) == ends_of(edges[first])) ++next;
    visit(first, next - first);
  }
}

/// Sets that grow together.
class Unions {
 public:
  explicit Unions(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }
  int root(int i) {
    while (parents_[index(i)] != i) i = parents_[index(i)] = parents_[index(parents_[index(i)])];
    return i;
  }
  void join(int a, int b) {
    const int one = root(a), other = root(b);
    parents_[index(std::max(one, other))] = std::min(one, other);
  }

 private:
  std::vector<int> parents_;
};

double diagonal_m(const TriangleMesh& mesh) {
  Eigen::Vector3d low = mesh.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  return (high - low).norm();
}

void check_numbers(const TriangleMesh& mesh, const std::string& name) {
  const auto bad = std::count_if(mesh.vertices_m.begin(), mesh.vertices_m.end(),
                                 [](const Eigen::Vector3d& v) { return !v.allFinite(); });
  if (bad > 0)
    throw MeshError(name + ": " + std::to_string(bad) + " of " +
                    std::to_string(mesh.vertices_m.size()) +
                    " vertices are no numbers: expected finite coordinates");
  const int count = static_cast<int>(mesh.vertices_m.size());
  const auto stray = std::count_if(
      mesh.triangles.begin(), mesh.triangles.end(),
      [&](const Eigen::Vector3i& t) { return t.minCoeff() < 0 || t.maxCoeff() >= count; });
  if (stray > 0)
    throw MeshError(
        name + ": " + std::to_string(stray) + " of " + std::to_string(mesh.triangles.size()) +
        " triangles name a vertex that is none: expected 0 to " + std::to_string(count - 1));
}

/// Gives vertices at one place one number.
int weld(TriangleMesh& mesh) {
  const double search_radius_m = kWeldShare * diagonal_m(mesh);
  const double search_radius_squared_m2 = search_radius_m * search_radius_m;
  const Eigen::Vector3d low = mesh.vertices_m.front();
  // Of cells two reaches wide only the own and the nearer neighbour along each axis matter; the box
  // is 500,000 of them across at most, so that a cell's three numbers fit in one.
  const double cell_m = std::max(2.0 * search_radius_m, 1e-300);
  constexpr std::int64_t kAcross = 1 << 21;
  std::unordered_map<std::int64_t, std::vector<int>> cells;
  std::vector<int> kept(mesh.vertices_m.size());
  int welded = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    realtime::throw_if_stopped();
    std::int64_t own[3], nearer[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double place = (mesh.vertices_m[i][axis] - low[axis]) / cell_m,
                   cell = std::floor(place);
      own[axis] = static_cast<std::int64_t>(cell);
      nearer[axis] = own[axis] + (place - cell < 0.5 ? -1 : 1);
    }
    const auto key = [&](int n) {
      std::int64_t number = 0;
      for (int axis = 0; axis < 3; ++axis)
        number = number * kAcross + ((n >> axis & 1) != 0 ? nearer : own)[axis] + kAcross / 2;
      return number;
    };
    kept[i] = static_cast<int>(i);
    for (int n = 0; n < 8 && kept[i] == static_cast<int>(i); ++n) {
      const auto found = cells.find(key(n));
      if (found == cells.end()) continue;
      for (const int other : found->second)
        if ((mesh.vertices_m[index(other)] - mesh.vertices_m[i]).squaredNorm() <=
            search_radius_squared_m2) {
          kept[i] = other;
          ++welded;
          break;
        }
    }
    if (kept[i] == static_cast<int>(i)) cells[key(0)].push_back(kept[i]);
  }
  for (Eigen::Vector3i& triangle : mesh.triangles)
    for (int& vertex : triangle) vertex = kept[index(vertex)];
  return welded;
}

int drop_degenerate(TriangleMesh& mesh) {
  return static_cast<int>(std::erase_if(mesh.triangles, [](const Eigen::Vector3i& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  }));
}

/// Keeps the first of the faces that share three corners, whichever way they go round.
int drop_doubled(TriangleMesh& mesh) {
  std::map<std::array<int, 3>, int> seen;
  return static_cast<int>(std::erase_if(mesh.triangles, [&](const Eigen::Vector3i& t) {
    realtime::throw_if_stopped();
    std::array<int, 3> corners = {t[0], t[1], t[2]};
    std::sort(corners.begin(), corners.end());
    return seen[corners]++ > 0;
  }));
}

/// The edges of one face, as it has them.
std::vector<Eigen::Vector2i> border_of(const std::vector<HalfEdge>& edges) {
  std::vector<Eigen::Vector2i> border;
  for_each_edge(edges, [&](std::size_t first, std::size_t faces) {
    if (faces == 1) border.emplace_back(edges[first].from, edges[first].to);
  });
  return border;
}

void check_edges(const std::vector<HalfEdge>& edges, const std::string& name) {
  int open = 0, crowded = 0;
  for_each_edge(edges, [&](std::size_t, std::size_t faces) {
    open += faces == 1 ? 1 : 0;
    crowded += faces > 2 ? 1 : 0;
  });
  if (open + crowded > 0)
    throw NotSolid(name + ": not closed: " + std::to_string(open) +
                   " boundary edges (of one face), " + std::to_string(crowded) +
                   " non-manifold edges (of three or more): expected two faces at every edge");
}

/// Turns faces until neighbours agree, the smaller part of each piece; the pieces by face.
struct Pieces {
  std::vector<int> of_face;  // numbered from 0
  int count = 0;
  int turned = 0;
};

Pieces orient(TriangleMesh& mesh, const std::vector<HalfEdge>& edges, const std::string& name) {
  struct Neighbour {
    int face;
    bool agrees;
  };
  std::vector<std::vector<Neighbour>> neighbours(mesh.triangles.size());
  for_each_edge(edges, [&](std::size_t first, std::size_t) {
    const HalfEdge &a = edges[first], &b = edges[first + 1];
    neighbours[index(a.face)].push_back({b.face, a.from == b.to});
    neighbours[index(b.face)].push_back({a.face, a.from == b.to});
  });
  Pieces pieces;
  pieces.of_face.assign(mesh.triangles.size(), -1);
  std::vector<char> is_turned(mesh.triangles.size(), 0);
  int torn = 0;
  for (std::size_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (pieces.of_face[seed] >= 0) continue;
    std::vector<int> piece = {static_cast<int>(seed)};
    pieces.of_face[seed] = pieces.count;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      realtime::throw_if_stopped();
      const int face = piece[i];
      for (const auto& [other, agrees] : neighbours[index(face)]) {
        const char wanted =
            static_cast<char>(agrees ? is_turned[index(face)] : !is_turned[index(face)]);
        if (pieces.of_face[index(other)] < 0) {
          pieces.of_face[index(other)] = pieces.count;
          is_turned[index(other)] = wanted;
          piece.push_back(other);
        } else if (is_turned[index(other)] != wanted) {
          ++torn;
        }
      }
    }
    ++pieces.count;
    const auto turned = static_cast<std::size_t>(
        std::count_if(piece.begin(), piece.end(), [&](int f) { return is_turned[index(f)]; }));
    if (2 * turned > piece.size())
      for (const int face : piece) is_turned[index(face)] = !is_turned[index(face)];
    for (const int face : piece) {
      if (!is_turned[index(face)]) continue;
      std::swap(mesh.triangles[index(face)][0], mesh.triangles[index(face)][1]);
      ++pieces.turned;
    }
  }
  if (torn > 0)
    throw NotSolid(
        name + ": not orientable: at " + std::to_string(torn / 2) +
        " edges its faces cannot agree on an outside: expected a surface with two sides");
  return pieces;
}

/// Gives each fan of faces round a vertex a vertex of its own.
int split_pinched(TriangleMesh& mesh, const std::vector<HalfEdge>& edges) {
  const auto corner = [&](int face, int vertex) {
    const Eigen::Vector3i& t = mesh.triangles[index(face)];
    return 3 * face + (t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2);
  };
  Unions fans(3 * mesh.triangles.size());
  for_each_edge(edges, [&](std::size_t first, std::size_t) {
    const HalfEdge &a = edges[first], &b = edges[first + 1];
    fans.join(corner(a.face, a.from), corner(b.face, a.from));
    fans.join(corner(a.face, a.to), corner(b.face, a.to));
  });
  int split = 0;
  std::vector<int> fan_of(mesh.vertices_m.size(), -1);
  std::unordered_map<int, int> own;  // fan: its vertex
  TriangleMesh result = mesh;
  for (int c = 0; c < static_cast<int>(3 * mesh.triangles.size()); ++c) {
    realtime::throw_if_stopped();
    const int vertex = mesh.triangles[index(c / 3)][c % 3], fan = fans.root(c);
    if (fan_of[index(vertex)] < 0) fan_of[index(vertex)] = fan;
    if (fan_of[index(vertex)] == fan) continue;
    const auto [place, is_new] = own.try_emplace(fan, static_cast<int>(result.vertices_m.size()));
    if (is_new) {
      result.vertices_m.push_back(mesh.vertices_m[index(vertex)]);
      ++split;
    }
    result.triangles[index(c / 3)][c % 3] = place->second;
  }
  mesh = std::move(result);
  return split;
}

void drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<int> number(mesh.vertices_m.size(), -1);
  std::vector<Eigen::Vector3d> used;
  for (Eigen::Vector3i& triangle : mesh.triangles)
    for (int& vertex : triangle) {
      if (number[index(vertex)] < 0) {
        number[index(vertex)] = static_cast<int>(used.size());
        used.push_back(mesh.vertices_m[index(vertex)]);
      }
      vertex = number[index(vertex)];
    }
  mesh.vertices_m = std::move(used);
}

}  // namespace

ClosedMesh make_closed(TriangleMesh mesh, std::string_view mesh_name) {
  const std::string name(mesh_name);
  if (mesh.triangles.empty() || mesh.vertices_m.empty())
    throw MeshError(name + ": 0 triangles: expected a closed surface");
  check_numbers(mesh, name);
  MeshRepair repair;
  drop_unused_vertices(mesh);
  repair.welded_vertices = weld(mesh);
  repair.degenerate_faces = drop_degenerate(mesh);
  repair.doubled_faces = drop_doubled(mesh);
  if (mesh.triangles.empty())
    throw MeshError(name + ": every face is degenerate: expected a closed surface");
  repair.holes = close_small_holes(mesh, border_of(sorted_edges(mesh)));
  std::vector<HalfEdge> edges = sorted_edges(mesh);
  check_edges(edges, name);
  repair.split_vertices = split_pinched(mesh, edges);
  edges = sorted_edges(mesh);
  const Pieces pieces = orient(mesh, edges, name);
  repair.turned_faces = pieces.turned;
  const Crossings crossings = count_crossings(mesh, pieces.of_face, name);
  if (crossings.between_pieces > 0)
    throw NotSolid(name + ": its " + std::to_string(pieces.count) +
                   " pieces cut one another: " + std::to_string(crossings.between_pieces) +
                   " edges pierce a face of another piece: expected pieces that keep apart");
  repair.turned_components = turn_pieces(mesh, pieces.of_face, pieces.count, name);
  drop_unused_vertices(mesh);
  return {std::move(mesh), repair, pieces.count, crossings.within_pieces};
}

}  // namespace stillgrid::mesh
