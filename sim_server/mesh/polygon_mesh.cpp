#include "sim_server/mesh/polygon_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/mesh/mesh_file.hpp"

namespace stillgrid::mesh {
namespace {

using Point = Eigen::Vector2d;

/// Twice the area of a triangle, positive if it is counter-clockwise.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// The normal of an outline by Newell's sum, whose length is twice the area.
Eigen::Vector3d newell(std::span<const Eigen::Vector3d> outline) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < outline.size(); ++i)
    sum += (outline[i] - outline[0]).cross(outline[(i + 1) % outline.size()] - outline[0]);
  return sum;
}

/// Seen from the end of its normal, in units of its box.
std::vector<Point> seen_along(const Eigen::Vector3d& normal,
                              std::span<const Eigen::Vector3d> outline) {
  const Eigen::Vector3d right = normal.unitOrthogonal(), up = normal.cross(right);
  double size = 0.0;
  for (const Eigen::Vector3d& corner : outline)
    size = std::max(size, (corner - outline[0]).cwiseAbs().maxCoeff());
  std::vector<Point> seen;
  for (const Eigen::Vector3d& corner : outline)
    seen.emplace_back(right.dot(corner - outline[0]) / size, up.dot(corner - outline[0]) / size);
  return seen;
}

constexpr double kFlat = 1e-12;  // of the box's square: an ear without area

bool is_convex(const std::vector<Point>& outline) {
  const std::size_t count = outline.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Point &b = outline[(i + 1) % count], &c = outline[(i + 2) % count];
    if (!(turn(outline[i], b, c) > kFlat)) return false;
    // An outline that goes round twice turns one way too, but not as seen from one corner.
    if (i > 0 && i + 1 < count && !(turn(outline[0], outline[i], outline[i + 1]) > kFlat))
      return false;
  }
  return true;
}

bool crosses(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto apart = [](double left, double right) {
    return (left > kFlat && right < -kFlat) || (left < -kFlat && right > kFlat);
  };
  return apart(turn(a, b, c), turn(a, b, d)) && apart(turn(c, d, a), turn(c, d, b));
}

/// Comparisons that cutting may take; a face of n corners takes n^2 at least.
class Budget {
 public:
  /// False once the whole is spent.
  bool spend(std::size_t comparisons) {
    realtime::throw_if_stopped();
    left_ -= std::min(left_, comparisons);
    return left_ > 0;
  }

 private:
  std::size_t left_ = 2'000'000'000;
};

enum class Outcome { kCut, kCrossed, kTooLong };

Outcome check_outline(const std::vector<Point>& outline, Budget& budget) {
  const std::size_t count = outline.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (!budget.spend(count - i)) return Outcome::kTooLong;
    for (std::size_t k = i + 2; k < count; ++k)
      if (crosses(outline[i], outline[i + 1], outline[k], outline[(k + 1) % count]))
        return Outcome::kCrossed;
  }
  return Outcome::kCut;
}

/// Cuts ears off a simple outline, beginning with its second corner so that what is convex becomes
/// a fan; calls take with the numbers of each ear's corners.
class EarCutter {
 public:
  EarCutter(const std::vector<Point>& outline, Budget& budget) : points_(outline), budget_(budget) {
    for (std::size_t i = 0; i < outline.size(); ++i) left_.push_back(i);
  }

  template <typename Take>
  Outcome cut(Take&& take) {
    std::size_t at = 1, tried = 0;
    while (left_.size() > 3) {
      if (!budget_.spend(left_.size())) return Outcome::kTooLong;
      at %= left_.size();
      // Corners on a straight line are cut last of all: their ears have no area.
      if (is_ear(at, tried >= left_.size())) {
        take(before(at), left_[at], after(at));
        left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(at));
        tried = 0;
      } else {
        ++at;
        if (++tried > 2 * left_.size()) return Outcome::kCrossed;
      }
    }
    take(left_[0], left_[1], left_[2]);
    return Outcome::kCut;
  }

 private:
  [[nodiscard]] std::size_t before(std::size_t at) const {
    return left_[(at + left_.size() - 1) % left_.size()];
  }
  [[nodiscard]] std::size_t after(std::size_t at) const { return left_[(at + 1) % left_.size()]; }

  [[nodiscard]] bool is_ear(std::size_t at, bool may_be_flat) const {
    const Point &a = points_[before(at)], &b = points_[left_[at]], &c = points_[after(at)];
    const double area = turn(a, b, c);
    if (may_be_flat && std::abs(area) <= kFlat) return true;
    if (area <= kFlat) return false;
    return std::none_of(left_.begin(), left_.end(), [&](std::size_t other) {
      const Point& p = points_[other];
      // A bridge to a hole comes by the same place twice.
      if (p == a || p == b || p == c) return false;
      return turn(a, b, p) >= -kFlat && turn(b, c, p) >= -kFlat && turn(c, a, p) >= -kFlat;
    });
  }

  const std::vector<Point>& points_;
  Budget& budget_;
  std::vector<std::size_t> left_;
};

/// Cuts one face; see cut_into_triangles().
Outcome cut_face(const PolygonMesh& mesh, std::span<const std::int32_t> corners, Budget& budget,
                 std::vector<Eigen::Vector3i>& triangles) {
  const auto take = [&](std::size_t a, std::size_t b, std::size_t c) {
    triangles.emplace_back(corners[a], corners[b], corners[c]);
  };
  if (corners.size() == 3) {
    take(0, 1, 2);
    return Outcome::kCut;
  }
  std::vector<Eigen::Vector3d> places;
  for (const std::int32_t vertex : corners)
    places.push_back(mesh.vertices[static_cast<std::size_t>(vertex)]);
  const Eigen::Vector3d normal = newell(places).stableNormalized();
  const bool has_area = normal.squaredNorm() > 0.5;
  const std::vector<Point> outline =
      has_area ? seen_along(normal, places) : std::vector<Point>(places.size(), Point::Zero());
  if (!has_area || is_convex(outline)) {
    // What has no area may be cut anyhow: its triangles have none either.
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) take(0, i, i + 1);
    return Outcome::kCut;
  }
  const Outcome outcome = check_outline(outline, budget);
  return outcome == Outcome::kCut ? EarCutter(outline, budget).cut(take) : outcome;
}

void check_room(std::size_t count, std::size_t most, const std::string& name, const char* what) {
  if (count < most) return;
  throw MeshError(name + ": more than " + std::to_string(most) + " " + what +
                  ": expected a smaller mesh");
}

void check_vertices(const PolygonMesh& polygons, const std::string& name) {
  constexpr double kFarthest = 1e30;  // squares and cubes of it are numbers too
  for (std::size_t i = 0; i < polygons.vertices.size(); ++i)
    if (!(polygons.vertices[i].cwiseAbs().maxCoeff() <= kFarthest) ||
        !polygons.vertices[i].allFinite())
      throw MeshError(name + ": vertex " + std::to_string(i + 1) +
                      ": is no number: expected finite coordinates up to 1e30");
}

}  // namespace

void PolygonMesh::add_vertex(double x, double y, double z) {
  check_room(vertices.size(), 3 * kMaxTriangles, name, "vertices");
  vertices.emplace_back(x, y, z);
}

void PolygonMesh::add_corner(std::int64_t vertex) {
  check_room(corners.size(), 4 * kMaxTriangles, name, "corners");
  corners.push_back(vertex >= 0 && vertex <= INT32_MAX ? static_cast<std::int32_t>(vertex)
                                                       : kNoVertex);
}

void PolygonMesh::end_face() {
  check_room(face_ends.size(), kMaxTriangles, name, "faces");
  face_ends.push_back(corners.size());
}

TriangleMesh cut_into_triangles(PolygonMesh polygons) {
  const std::string& name = polygons.name;
  check_vertices(polygons, name);
  std::vector<Eigen::Vector3i> triangles;
  Budget budget;
  std::size_t begin = 0;
  for (std::size_t face = 0; face < polygons.face_ends.size(); ++face) {
    realtime::throw_if_stopped();
    const std::size_t end = polygons.face_ends[face];
    const auto corners =
        std::span<const std::int32_t>(polygons.corners).subspan(begin, end - begin);
    begin = end;
    const auto refuse = [&](const std::string& what) {
      throw MeshError(name + ": face " + std::to_string(face + 1) + " of " +
                      std::to_string(corners.size()) + " corners: " + what);
    };
    for (const std::int32_t vertex : corners)
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= polygons.vertices.size())
        refuse("names a vertex that is none: expected one of " +
               std::to_string(polygons.vertices.size()));
    if (corners.size() < 3) continue;
    if (triangles.size() + corners.size() - 2 > kMaxTriangles)
      refuse("is too much: expected at most " + std::to_string(kMaxTriangles) + " triangles");
    switch (cut_face(polygons, corners, budget, triangles)) {
      case Outcome::kCut:
        break;
      case Outcome::kCrossed:
        refuse("its outline crosses itself: expected a simple polygon");
        break;
      case Outcome::kTooLong:
        refuse("concave faces take too long to cut: expected fewer corners");
    }
  }
  return {std::move(polygons.vertices), std::move(triangles)};
}

}  // namespace stillgrid::mesh
