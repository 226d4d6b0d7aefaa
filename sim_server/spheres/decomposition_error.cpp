#include "sim_server/spheres/decomposition_error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <utility>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/mesh/mesh_crossings.hpp"
#include "sim_server/spheres/ball_tree.hpp"

namespace stillgrid::spheres {
namespace {

using Corners = std::array<Eigen::Vector3d, 3>;

/// A part of a triangle or of a sphere, and the balls that matter to it.
struct Patch {
  Corners corners;                   // of a sphere's: unit directions
  std::vector<std::uint32_t> near;   // balls, ascending
  std::size_t owner = 0;             // triangle or ball
  double low_m = 0.0, high_m = 0.0;  // bounds of its largest distance
  double radius_m = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d worst_m = Eigen::Vector3d::Zero();  // where low_m was found
  bool is_filled = false;                             // the distance is out of the union
};

bool operator<(const Patch& a, const Patch& b) {
  return a.high_m < b.high_m;
}

std::array<Corners, 4> quarters(const Corners& c) {
  const Eigen::Vector3d a = 0.5 * (c[0] + c[1]), b = 0.5 * (c[1] + c[2]), d = 0.5 * (c[2] + c[0]);
  return {Corners{c[0], a, d}, Corners{a, c[1], b}, Corners{d, b, c[2]}, Corners{a, b, d}};
}

/// How far every point of a part of a triangle has to go along its normal to leave the union, at
/// most.
double way_along_m(const Patch& patch, std::span<const Ball> balls, const Eigen::Vector3d& normal) {
  double way_m = 0.0;
  std::vector<char> is_met(patch.near.size(), 0);
  for (bool is_longer = true; is_longer;) {
    is_longer = false;
    for (std::size_t k = 0; k < patch.near.size(); ++k) {
      if (is_met[k]) continue;
      const Ball& ball = balls[patch.near[k]];
      const Eigen::Vector3d to_centre_m = ball.centre_m - patch.centre_m;
      const double along_m = to_centre_m.dot(normal);
      const double aside_m = (to_centre_m - along_m * normal).norm();
      const double beyond_m = along_m - std::clamp(along_m, 0.0, way_m);
      if (std::hypot(beyond_m, aside_m) > ball.radius_m + patch.radius_m) continue;
      is_met[k] = 1;
      const double nearer_m = std::max(0.0, aside_m - patch.radius_m);
      const double half_chord_m =
          std::sqrt(std::max(0.0, ball.radius_m * ball.radius_m - nearer_m * nearer_m));
      if (along_m + half_chord_m <= way_m) continue;
      way_m = along_m + half_chord_m;
      is_longer = true;
    }
  }
  return way_m;
}

/// The same along any path: pushed out of one ball after the other, from a start nearby.
double way_pushed_m(const Patch& patch, std::span<const Ball> balls, Eigen::Vector3d point_m) {
  constexpr int kMaxPushes = 12;
  for (int push = 0; push < kMaxPushes; ++push) {
    double deepest_m = 0.0;
    std::size_t ball = balls.size();
    for (const std::uint32_t i : patch.near) {
      const double depth_m = balls[i].radius_m - (point_m - balls[i].centre_m).norm();
      if (depth_m <= deepest_m) continue;
      deepest_m = depth_m;
      ball = i;
    }
    if (ball == balls.size()) return (point_m - patch.centre_m).norm() + patch.radius_m;
    constexpr double kClear = 1.0 + 1e-9;
    point_m = balls[ball].centre_m +
              kClear * balls[ball].radius_m * (point_m - balls[ball].centre_m).normalized();
  }
  return std::numeric_limits<double>::infinity();
}

constexpr double kReaches = 4.0;  // ways out are followed so far

/// Bounds a part of a triangle; drops the balls that are nowhere the nearest, nor on a way out.
void bound_on_mesh(double size_m, std::span<const Ball> balls, double search_radius_m,
                   Patch& patch) {
  const Corners& c = patch.corners;
  patch.centre_m = (c[0] + c[1] + c[2]) / 3.0;
  patch.radius_m = 0.0;
  for (const Eigen::Vector3d& corner : c)
    patch.radius_m = std::max(patch.radius_m, (corner - patch.centre_m).norm());
  const auto gap_m = [&](std::size_t i, const Eigen::Vector3d& point_m) {
    return (point_m - balls[i].centre_m).norm() - balls[i].radius_m;
  };
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double outside_m = kFar, least_m = kFar;
  std::array<double, 3> at_corner = {kFar, kFar, kFar};
  std::vector<double> gaps_m(patch.near.size());
  for (std::size_t k = 0; k < patch.near.size(); ++k) {
    double largest_m = -kFar;
    for (std::size_t i = 0; i < 3; ++i) {
      const double gap = gap_m(patch.near[k], c[i]);
      largest_m = std::max(largest_m, gap);
      at_corner[i] = std::min(at_corner[i], gap);
    }
    outside_m = std::min(outside_m, largest_m);
    gaps_m[k] = gap_m(patch.near[k], patch.centre_m);
    least_m = std::min(least_m, gaps_m[k]);
  }
  std::size_t kept = 0;
  for (std::size_t k = 0; k < patch.near.size(); ++k)
    if (gaps_m[k] - patch.radius_m <= std::max(outside_m, kReaches * search_radius_m))
      patch.near[kept++] = patch.near[k];
  patch.near.resize(kept);

  const auto worst = std::max_element(at_corner.begin(), at_corner.end());
  patch.worst_m = c[static_cast<std::size_t>(worst - at_corner.begin())];
  patch.low_m = std::max({0.0, *worst, -least_m});
  patch.high_m = std::max(0.0, outside_m);
  patch.is_filled = false;
  if (least_m >= patch.radius_m) return;  // no ball reaches it
  const Eigen::Vector3d face = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
  double way_m = way_along_m(patch, balls, face);
  if (way_m > std::max(patch.high_m, 0.9 * search_radius_m))
    for (const double start : {0.0, 0.5, 1.0})
      way_m = std::min(way_m,
                       way_pushed_m(patch, balls, patch.centre_m + start * search_radius_m * face));
  if (!(way_m <= kReaches * search_radius_m)) way_m = size_m;  // past the balls that were kept
  if (way_m > patch.high_m) {
    patch.high_m = way_m;
    patch.is_filled = true;
  }
}

/// Bounds a part of a sphere; returns false if other balls bury it.
bool bound_on_union(const MeshSolid& solid, std::span<const Ball> balls, double sticks_out_m,
                    Patch& patch) {
  const Ball& ball = balls[patch.owner];
  const Eigen::Vector3d middle =
      (patch.corners[0] + patch.corners[1] + patch.corners[2]).normalized();
  patch.centre_m = ball.centre_m + ball.radius_m * middle;
  patch.radius_m = 0.0;
  for (const Eigen::Vector3d& corner : patch.corners)
    patch.radius_m =
        std::max(patch.radius_m, ball.radius_m * (corner.normalized() - middle).norm());
  bool is_buried = false, is_exposed = true;
  std::size_t kept = 0;
  for (const std::uint32_t i : patch.near) {
    const double gap_m = (patch.centre_m - balls[i].centre_m).norm() - balls[i].radius_m;
    is_buried = is_buried || gap_m < -patch.radius_m;
    is_exposed = is_exposed && gap_m >= 0.0;
    if (gap_m <= patch.radius_m) patch.near[kept++] = i;
  }
  patch.near.resize(kept);
  if (is_buried) return false;
  const double signed_m = solid.distance.signed_distance_m(patch.centre_m);
  // Outside the solid no point of a ball is farther than it sticks out. Where a mesh cuts itself,
  // what is outside is believed of small patches only, and where they do not contradict it.
  const bool is_believed =
      !solid.cuts_itself || (patch.radius_m <= 0.5 * sticks_out_m && signed_m <= sticks_out_m);
  patch.high_m = std::max(signed_m + patch.radius_m, patch.radius_m - signed_m);
  if (is_believed)
    patch.high_m =
        std::max(std::min(signed_m + patch.radius_m, sticks_out_m), patch.radius_m - signed_m);
  patch.low_m = is_exposed ? std::abs(signed_m) : 0.0;
  return true;
}

double sticks_out_m(const MeshSolid& solid, const Ball& ball) {
  return std::max(0.0, ball.radius_m + solid.distance.signed_distance_m(ball.centre_m));
}

/// What is cut into patches: the triangles or the spheres.
struct MeshSide {
  const MeshSolid& solid;
  std::span<const Ball> balls;
  double search_radius_m;  // how far a ball may stick out, about
  BallTree tree{balls};

  template <typename Take>
  void for_each_root(Take&& take) const {
    for (std::size_t t = 0; t < solid.mesh.triangles.size(); ++t) {
      Patch patch;
      for (std::size_t k = 0; k < 3; ++k)
        patch.corners[k] =
            solid.mesh
                .vertices_m[static_cast<std::size_t>(solid.mesh.triangles[t][static_cast<int>(k)])];
      patch.owner = t;
      patch.near = balls_that_matter(patch.corners);
      if (bound(patch)) take(std::move(patch));
    }
  }
  bool bound(Patch& patch) const {
    bound_on_mesh(solid.size_m, balls, search_radius_m, patch);
    return true;
  }

 private:
  /// All that bound_on_mesh() keeps: no corner is farther outside the nearest ball than the middle
  /// and the way there.
  [[nodiscard]] std::vector<std::uint32_t> balls_that_matter(const Corners& c) const {
    const Eigen::Vector3d centre_m = (c[0] + c[1] + c[2]) / 3.0;
    double radius_m = 0.0;
    for (const Eigen::Vector3d& corner : c)
      radius_m = std::max(radius_m, (corner - centre_m).norm());
    const double outside_m = tree.least_gap_m(centre_m) + radius_m;
    constexpr double kRounding = 1.0 + 1e-9;
    return tree.balls_within(
        centre_m, kRounding * (std::max(outside_m, kReaches * search_radius_m) + radius_m));
  }
};

struct UnionSide {
  const MeshSolid& solid;
  std::span<const Ball> balls;
  std::vector<double> out_m;  // each ball sticks out

  BallTree tree;

  UnionSide(const MeshSolid& of, std::span<const Ball> with) : solid(of), balls(with), tree(with) {
    for (const Ball& ball : balls) out_m.push_back(sticks_out_m(solid, ball));
  }
  /// Ascending.
  [[nodiscard]] std::vector<std::uint32_t> balls_that_meet(std::size_t i) const {
    auto near = tree.balls_within(balls[i].centre_m, balls[i].radius_m);
    std::erase(near, static_cast<std::uint32_t>(i));
    return near;
  }
  template <typename Take>
  void for_each_root(Take&& take) const {
    for (std::size_t i = 0; i < balls.size(); ++i) {
      const std::vector<std::uint32_t> near = balls_that_meet(i);
      for (int octant = 0; octant < 8; ++octant) {
        Patch patch;
        for (int k = 0; k < 3; ++k)
          patch.corners[static_cast<std::size_t>(k)] =
              (octant >> k & 1 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(k);
        patch.owner = i;
        patch.near = near;
        if (bound(patch)) take(std::move(patch));
      }
    }
  }
  bool bound(Patch& patch) const { return bound_on_union(solid, balls, out_m[patch.owner], patch); }
};

template <typename Side, typename Take>
void split(const Side& side, const Patch& patch, Take&& take) {
  realtime::throw_if_stopped();
  for (const Corners& corners : quarters(patch.corners)) {
    Patch part;
    part.corners = corners;
    part.owner = patch.owner;
    part.near = patch.near;
    const double high_m = patch.high_m;
    if (!side.bound(part)) continue;
    part.high_m = std::min(part.high_m, high_m);  // a part is no farther than the whole
    take(std::move(part));
  }
}

/// Patches cut for one distance, and more for each triangle or ball, and kept at a time: what is
/// left then is bounded less tightly.
constexpr std::size_t kMaxSplits = 4'000'000, kMaxSplitsOfEach = 2'000, kMaxPatches = 2'000'000;

/// The largest distance on one side, from above.
template <typename Side>
double largest_m(const Side& side, double precision_m) {
  std::priority_queue<Patch> patches;
  double found_m = 0.0;
  const auto keep = [&](Patch&& patch) {
    found_m = std::max(found_m, patch.low_m);
    if (patch.high_m > found_m + precision_m) patches.push(std::move(patch));
  };
  side.for_each_root(keep);
  double given_up_m = 0.0;
  std::size_t splits = 0;
  const std::size_t most_splits = kMaxSplits + kMaxSplitsOfEach * side.balls.size();
  while (!patches.empty() && patches.top().high_m > std::max(found_m + precision_m, given_up_m)) {
    const Patch patch = patches.top();
    patches.pop();
    // A filled crevice has no distance found: its way out is a bound that cutting does not better.
    if (patch.radius_m < 0.1 * precision_m || ++splits > most_splits ||
        patches.size() > kMaxPatches)
      given_up_m = std::max(given_up_m, patch.high_m);
    else
      split(side, patch, keep);
  }
  return std::max(found_m + precision_m, given_up_m);
}

/// Most places that are looked for at once; where there are more, others are found once these are
/// mended.
constexpr std::size_t kMaxPlaces = 200'000;

/// Calls visit on the patches of about spacing_m that are farther than limit_m; it tells whether it
/// kept a place. Returns how many patches were looked at.
template <typename Side, typename Visit>
std::size_t visit_farther(const Side& side, double limit_m, double spacing_m, Visit&& visit) {
  std::vector<Patch> stack;
  std::size_t places = 0, patches = 0;
  const auto keep = [&](Patch&& patch) {
    if (patch.high_m > limit_m) stack.push_back(std::move(patch));
  };
  side.for_each_root([&](Patch&& root) {
    if (places < kMaxPlaces) keep(std::move(root));
    while (!stack.empty() && places < kMaxPlaces) {
      const Patch patch = std::move(stack.back());
      stack.pop_back();
      ++patches;
      if (patch.radius_m <= spacing_m) {
        places += visit(patch) ? 1U : 0U;
      } else {
        split(side, patch, keep);
      }
    }
    stack.clear();
  });
  return patches;
}

}  // namespace

MeshSolid::MeshSolid(const mesh::TriangleMesh& closed) : mesh(closed), distance(closed) {
  Eigen::Vector3d low = mesh.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  size_m = (high - low).norm();
  const std::vector<int> one_piece(mesh.triangles.size(), 0);
  cuts_itself = mesh::count_crossings(mesh, one_piece, "mesh").within_pieces > 0;
}

TooFar find_too_far(const MeshSolid& solid, std::span<const Ball> balls, double limit_m,
                    double spacing_m) {
  TooFar far;
  const MeshSide of_mesh{solid, balls, limit_m};
  far.patches += visit_farther(of_mesh, limit_m, spacing_m, [&](const Patch& patch) {
    if (patch.is_filled) {
      far.filled_m.push_back(patch.centre_m);
    } else if (patch.low_m > limit_m) {
      far.uncovered.points_m.push_back(patch.worst_m);
      far.uncovered.normals.push_back((patch.corners[1] - patch.corners[0])
                                          .cross(patch.corners[2] - patch.corners[0])
                                          .normalized());
    } else {
      return false;
    }
    return true;
  });
  const UnionSide of_union(solid, balls);
  far.patches += visit_farther(of_union, limit_m, spacing_m, [&](const Patch& patch) {
    if (patch.low_m <= limit_m - patch.radius_m) return false;
    far.hollows_m.push_back(patch.centre_m);
    return true;
  });
  return far;
}

Decomposition with_error(const MeshSolid& solid, std::vector<Ball> balls, double precision_m) {
  Decomposition result;
  const UnionSide of_union(solid, balls);
  const double out_m = *std::max_element(of_union.out_m.begin(), of_union.out_m.end());
  // Balls that only touch the mesh from inside cut it by rounding: they reach farther than they are
  // out.
  result.mesh_to_union_m =
      largest_m(MeshSide{solid, balls, std::max(out_m, precision_m)}, precision_m);
  result.union_to_mesh_m = largest_m(of_union, precision_m);
  result.hausdorff_m = std::max(result.mesh_to_union_m, result.union_to_mesh_m);
  result.balls = std::move(balls);
  return result;
}

}  // namespace stillgrid::spheres
