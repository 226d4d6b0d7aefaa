#include "shared/publication/moving_records.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/collision/sphere_history.hpp"

namespace stillgrid::publication {
namespace {

/// Twice a probe's own size is searched fastest.
constexpr float kVoxelRatio = 2.0F;
/// Of a radius: more than the test of two swept bounds can round off.
constexpr float kRounding = 1e-6F;
/// Room of a swept bound when it is entered: of the radius, and for steps at the sphere's speed.
constexpr float kLeastRoom = 0.02F, kSteps = 8.0F;
/// What left its swept bound is widened in place, up to so many of all, and so much at once.
constexpr std::size_t kLeavingPart = 64;
constexpr float kWidest = 1.5F;

Eigen::Map<const Eigen::Vector3f> vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data());
}

std::array<float, 3> floats(const double* v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

/// It came just now: in the snapshot before it is nowhere.
void begin_history(proto::SphereRecord& record, const proto::SphereState& state) {
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  const proto::SphereState absent{{kNowhere, kNowhere, kNowhere}, {}};
  record.newest = state;
  record.before = absent;
}

}  // namespace

MovingRecords::MovingRecords(std::size_t capacity)
    : grid_(sizeof(proto::SnapshotHeader), capacity), bounds_(capacity), came_(capacity) {}

void MovingRecords::declare(const stillgrid_shapes& shapes) noexcept {
  const auto all = grid_.records();
  for (std::size_t i = 0; i < shapes.count; ++i) {
    proto::SphereRecord& record = all[i];
    const auto radius_m = static_cast<float>(shapes.radii_m[i]);
    const std::uint32_t material = shapes.materials == nullptr ? 0 : shapes.materials[i];
    const std::uint32_t body = shapes.bodies == nullptr ? 0 : shapes.bodies[i];
    came_[i] = came_[i] != 0 || i >= count_ || record.radius_m != radius_m ||
               record.material != material || record.body != body;
    record.radius_m = radius_m;
    record.material = material;
    record.body = body;
  }
  count_ = shapes.count;
}

void MovingRecords::push(std::size_t i, const double* position_m, const double* velocity_m_s,
                         float rate_per_s, bool was_shown) noexcept {
  proto::SphereRecord& record = records()[i];
  proto::SphereState state{floats(position_m), {}};
  const bool has_past = !is_first_ && came_[i] == 0;
  if (velocity_m_s != nullptr) {
    state.velocity_m_s = floats(velocity_m_s);
  } else if (has_past) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      state.velocity_m_s[axis] =
          rate_per_s * (state.position_m[axis] - record.newest.position_m[axis]);
  }
  if (has_past && !was_shown)
    record.newest = state;
  else if (has_past)
    collision::push_snapshot(record, state);
  else if (is_first_)
    collision::fill_history(record, state);
  else
    begin_history(record, state);
}

/// Whether the sphere's swept bound holds its newest snapshot; the older one it held before.
bool MovingRecords::is_held(std::size_t i) noexcept {
  const proto::SphereRecord& record = records()[i];
  const collision::SweptBound& bound = bounds_[i];
  const float away_m2 = (vector(record.newest.position_m) - vector(bound.centre_m)).squaredNorm();
  const float room_m = (1.0F - kRounding) * bound.bounding_radius_m - record.radius_m;
  if (away_m2 <= room_m * std::abs(room_m)) return true;
  needed_m_ = (std::sqrt(away_m2) + record.radius_m) * (1.0F + 2.0F * kRounding);
  return false;
}

/// Enters all anew, each with room for some steps at its speed.
void MovingRecords::enter(double period_s) {
  for (std::size_t i = 0; i < count_; ++i) {
    const proto::SphereRecord& record = records()[i];
    collision::SweptBound& bound = bounds_[i];
    bound = collision::bound_history(record);
    const float way_m =
        kSteps * static_cast<float>(period_s) * vector(record.newest.velocity_m_s).norm();
    bound.bounding_radius_m += std::min(record.radius_m, kLeastRoom * record.radius_m + way_m);
    came_[i] = 0;
  }
  grid_.enter({bounds_.data(), count_}, kVoxelRatio);
  entered_ = count_;
}

void MovingRecords::place(const double* positions_m, const double* velocities_m_s, double period_s,
                          bool was_shown) {
  const auto rate_per_s = static_cast<float>(1.0 / period_s);
  bool holds = !is_first_ && entered_ == count_;
  std::size_t left = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    push(i, positions_m + 3 * i, velocities_m_s == nullptr ? nullptr : velocities_m_s + 3 * i,
         rate_per_s, was_shown);
    if (!holds || (came_[i] == 0 && is_held(i))) continue;
    holds = came_[i] == 0 && ++left <= count_ / kLeavingPart + 1 && widen(i);
  }
  is_first_ = false;
  if (!holds) enter(period_s);
}

/// Lets a swept bound reach as far as was needed; false where it would be too wide for its level.
bool MovingRecords::widen(std::size_t i) noexcept {
  if (needed_m_ > kWidest * bounds_[i].bounding_radius_m) return false;
  bounds_[i].bounding_radius_m = needed_m_;
  grid_.grow(i, needed_m_);
  return true;
}

}  // namespace stillgrid::publication
