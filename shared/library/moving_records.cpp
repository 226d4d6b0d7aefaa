#include "shared/library/moving_records.hpp"

#include <Eigen/Core>
#include <limits>

#include "shared/collision/sphere_history.hpp"

namespace stillgrid::library {
namespace {

/// Twice a probe's own size is searched fastest.
constexpr float kVoxelRatio = 2.0F;

Eigen::Map<const Eigen::Vector3f> vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data());
}

std::array<float, 3> floats(const double* v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

/// It came just now: in no older snapshot is it anywhere.
void begin_history(proto::SphereRecord& record, const proto::SphereState& state) {
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  const proto::SphereState absent{{kNowhere, kNowhere, kNowhere}, {}};
  record.newest = state;
  record.older = {absent, absent};
  record.oldest_position_m = absent.position_m;
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

void MovingRecords::place(const double* positions_m, const double* velocities_m_s,
                          double period_s) {
  const std::span<proto::SphereRecord> all = records();
  const auto rate_per_s = static_cast<float>(1.0 / period_s);
  for (std::size_t i = 0; i < count_; ++i) {
    proto::SphereRecord& record = all[i];
    proto::SphereState state{floats(positions_m + 3 * i), {}};
    const bool has_past = !is_first_ && came_[i] == 0;
    if (velocities_m_s != nullptr) {
      state.velocity_m_s = floats(velocities_m_s + 3 * i);
    } else if (has_past) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        state.velocity_m_s[axis] =
            rate_per_s * (state.position_m[axis] - record.newest.position_m[axis]);
    }
    if (has_past)
      collision::push_snapshot(record, state);
    else if (is_first_)
      collision::fill_history(record, state);
    else
      begin_history(record, state);
    record.predicted_velocity_m_s = state.velocity_m_s;
    record.response = 0;
    came_[i] = 0;
    bounds_[i] = collision::bound_history(record, proto::kPredictionPeriods * period_s);
  }
  is_first_ = false;
  grid_.enter({bounds_.data(), count_}, kVoxelRatio);
  entered_ = count_;
}

void MovingRecords::cover_predictions(double period_s) noexcept {
  const std::span<proto::SphereRecord> all = records();
  const auto ahead = static_cast<float>(proto::kPredictionPeriods * period_s);
  const auto behind = static_cast<float>(proto::kLongestPredictionLag_s);
  for (std::size_t i = 0; i < entered_; ++i) {
    const proto::SphereRecord& record = all[i];
    const collision::SweptBound& bound = grid_.swept_bound(i);
    const Eigen::Vector3f from_m = vector(record.newest.position_m) - vector(bound.centre_m);
    const Eigen::Vector3f velocity_m_s = vector(record.predicted_velocity_m_s);
    const float farthest_m2 = std::max((from_m + ahead * velocity_m_s).squaredNorm(),
                                       (from_m - behind * velocity_m_s).squaredNorm());
    const float reach_m = (std::sqrt(farthest_m2) + record.radius_m) * (1.0F + 1e-6F);
    if (reach_m > bound.bounding_radius_m) grid_.grow(i, reach_m);
  }
}

void MovingRecords::forget_predictions() noexcept {
  for (proto::SphereRecord& record : records()) {
    record.predicted_velocity_m_s = record.newest.velocity_m_s;
    record.response = 0;
  }
}

}  // namespace stillgrid::library
