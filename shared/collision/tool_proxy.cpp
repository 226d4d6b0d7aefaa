#include "shared/collision/tool_proxy.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace stillgrid::collision {
namespace {

/// Half-spaces that push by more than nothing and by less than their depth. They touch.
class Between {
 public:
  [[nodiscard]] bool has(const HalfSpace* space) const noexcept {
    return std::find(spaces_.begin(), spaces_.begin() + count_, space) != spaces_.begin() + count_;
  }
  /// Returns false if there is no room.
  bool add(HalfSpace* space) noexcept {
    if (count_ == kMaxBetween) return false;
    spaces_[at(count_++)] = space;
    return true;
  }
  /// Changes the pushes until all touch. Those that push by nothing, or by their depth, leave.
  template <class Overlap>
  Eigen::Vector3d solve(Eigen::Vector3d way_m, const Overlap& overlap_m) noexcept;

 private:
  static constexpr int kMaxBetween = 4;  // three are independent
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  using Pushes = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxBetween, 1>;
  using Products =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxBetween, kMaxBetween>;

  std::array<HalfSpace*, kMaxBetween> spaces_{};
  int count_ = 0;
};

template <class Overlap>
Eigen::Vector3d Between::solve(Eigen::Vector3d way_m, const Overlap& overlap_m) noexcept {
  constexpr double kRidge = 1e-9;  // if normals depend on each other, one of them leaves
  while (count_ > 0) {
    Products products(count_, count_);
    Pushes change_m(count_);
    for (int i = 0; i < count_; ++i) {
      change_m[i] = overlap_m(*spaces_[at(i)], way_m);
      for (int j = 0; j < count_; ++j)
        products(i, j) = spaces_[at(i)]->normal.dot(spaces_[at(j)]->normal);
      products(i, i) += kRidge;
    }
    change_m = products.ldlt().solve(change_m).eval();
    double share = 1.0;
    int ends = -1;
    for (int i = 0; i < count_; ++i) {
      const HalfSpace& space = *spaces_[at(i)];
      const double room_m = change_m[i] > 0.0 ? space.depth_m - space.push_m : -space.push_m;
      if (share * std::abs(change_m[i]) <= std::abs(room_m)) continue;
      share = room_m / change_m[i];
      ends = i;
    }
    for (int i = 0; i < count_; ++i) {
      HalfSpace& space = *spaces_[at(i)];
      way_m += share * change_m[i] * space.normal;
      space.push_m += share * change_m[i];
    }
    if (ends < 0) break;
    HalfSpace& ended = *spaces_[at(ends)];
    ended.push_m = change_m[ends] > 0.0 ? ended.depth_m : 0.0;
    std::swap(spaces_[at(ends)], spaces_[at(--count_)]);
  }
  return way_m;
}

}  // namespace

Eigen::Vector3d push_out(const Eigen::Vector3d& goal_m, std::span<HalfSpace> spaces) noexcept {
  constexpr int kSteps = 64;
  constexpr double kTolerance_m = 1e-10;
  const auto overlap_m = [](const HalfSpace& space, const Eigen::Vector3d& at_m) {
    return -(space.gap_m + space.normal.dot(at_m - space.moved_m));
  };
  for (HalfSpace& space : spaces) {
    space.depth_m = overlap_m(space, goal_m);
    space.push_m = 0.0;
  }
  Between between;
  Eigen::Vector3d way_m = goal_m;
  for (int step = 0; step < kSteps; ++step) {
    HalfSpace* farthest = nullptr;  // from its share of the way
    double most_m = kTolerance_m;
    for (HalfSpace& space : spaces) {
      if (!(space.depth_m > 0.0) || between.has(&space)) continue;
      const double missing_m = overlap_m(space, way_m);
      const bool may_change = missing_m > 0.0 ? space.push_m < space.depth_m : space.push_m > 0.0;
      if (!may_change || !(std::abs(missing_m) > most_m)) continue;
      farthest = &space;
      most_m = std::abs(missing_m);
    }
    if (farthest == nullptr || !between.add(farthest)) break;
    way_m = between.solve(way_m, overlap_m);
  }
  return way_m;
}

Eigen::Vector3d StickingFriction::force_N(const Pull& pull) noexcept {
  const auto across = [&](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(v - pull.normal.dot(v) * pull.normal);
  };
  stretch_m = across(stretch_m + pull.moved_m);
  const Eigen::Vector3d damper_N = -pull.damping_N_s_per_m * across(pull.velocity_m_s);
  Eigen::Vector3d force_N = damper_N - pull.stiffness_N_per_m * stretch_m;
  const double size_N = force_N.norm();
  if (size_N > pull.limit_N) {
    force_N *= pull.limit_N / size_N;
    stretch_m = (damper_N - force_N) / pull.stiffness_N_per_m;
  }
  return force_N;
}

}  // namespace stillgrid::collision
