#include "haptic_server/safety/device_reading.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::safety {
namespace {

constexpr double kFarthest_m = 10.0;
constexpr std::uint64_t kStale_ns = 100'000'000;
/// A sensor slower than that is followed tick by tick: its next sample may be long in coming.
constexpr std::uint64_t kRecent_ns = 10'000'000;
constexpr double kFastest_m_s = 20.0;
constexpr std::uint64_t kLeapBelieved_ns = 100'000'000;
/// Encoder steps and rounding, where two readings come in no time.
constexpr double kSlack_m = 1e-3;

/// A device that declares a speed may be moved faster, but not this many times.
constexpr double kSpeedMargin = 3.0;
constexpr double kLeastMargin_m = 0.05;
constexpr double kMargin = 0.5;  // of the workspace's extent

/// Whether a position is where the device cannot be: encoders in other units, a lost reference.
bool is_outside(const Workspace& workspace, const Eigen::Vector3d& position_m) {
  for (int axis = 0; axis < 3; ++axis) {
    const double min_m = workspace.min_m[axis], max_m = workspace.max_m[axis];
    if (!(max_m > min_m)) continue;
    const double margin_m = std::max(kLeastMargin_m, kMargin * (max_m - min_m));
    if (position_m[axis] < min_m - margin_m || position_m[axis] > max_m + margin_m) return true;
  }
  return false;
}

/// Unit, or nothing.
std::optional<Eigen::Quaterniond> orientation(const stillgrid_device_state& state) {
  const auto& xyzw = state.orientation_xyzw;
  const Eigen::Quaterniond q(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  if ((state.valid & STILLGRID_STATE_ORIENTATION) == 0 || !(std::abs(q.squaredNorm() - 1.0) < 1e-3))
    return std::nullopt;
  return q.normalized();
}

}  // namespace

ReadingBounds reading_bounds(const stillgrid_device_descriptor& device) noexcept {
  ReadingBounds bounds;
  bounds.workspace = {Eigen::Vector3d(device.workspace_min_m),
                      Eigen::Vector3d(device.workspace_max_m)};
  if (device.max_speed_m_s > 0.0) bounds.max_speed_m_s = device.max_speed_m_s;
  return bounds;
}

std::uint32_t status_flags(const stillgrid_device_state& state) noexcept {
  const auto lacks = [&](std::uint32_t bit) {
    return (state.status_known & ~state.status & bit) != 0;
  };
  const auto has = [&](std::uint32_t bit) {
    return (state.status_known & state.status & bit) != 0;
  };
  return (lacks(STILLGRID_STATUS_MOTORS_ON) ? kFlagMotorsOff : 0U) |
         (lacks(STILLGRID_STATUS_ENABLED) ? kFlagNotEnabled : 0U) |
         (lacks(STILLGRID_STATUS_CALIBRATED) ? kFlagNotCalibrated : 0U) |
         (has(STILLGRID_STATUS_HOT) ? kFlagHot : 0U) |
         (has(STILLGRID_STATUS_FAULT) ? kFlagDeviceFault : 0U);
}

std::uint32_t DeviceReadingCheck::fault_of_pose(
    const stillgrid_device_state& state) const noexcept {
  const Eigen::Vector3d position_m(state.position_m);
  if ((state.valid & STILLGRID_STATE_POSITION) == 0) return kFlagNoPosition;
  if (position_m.hasNaN()) return kFlagNoNumber;
  if (!(position_m.stableNorm() <= kFarthest_m))
    return position_m.allFinite() ? kFlagTooFar : kFlagNoNumber;
  if (is_outside(bounds_.workspace, position_m)) return kFlagOutside;
  if ((state.valid & STILLGRID_STATE_ORIENTATION) != 0 && !orientation(state))
    return kFlagNoOrientation;
  return 0;
}

std::uint32_t DeviceReadingCheck::fault_of_time(const stillgrid_device_state& state,
                                                std::uint64_t now_ns) noexcept {
  if (state.time_ns < stamp_ns_) return kFlagStampBack;
  if (state.time_ns + kStale_ns < now_ns || state.time_ns > now_ns + kStale_ns)
    return kFlagStampOff;
  if (sequence_ != state.sequence) fresh_ns_ = now_ns;
  sequence_ = state.sequence;
  return now_ns - fresh_ns_ > kStale_ns ? kFlagFrozen : 0U;
}

bool DeviceReadingCheck::has_leapt(const Place& place, std::uint64_t now_ns) noexcept {
  const double fastest_m_s = std::min(kFastest_m_s, kSpeedMargin * bounds_.max_speed_m_s);
  const auto is_near = [&](const Place& before) {
    const double since_s = 1e-9 * static_cast<double>(now_ns - before.since_ns);
    return (place.position_m - before.position_m).norm() <= kSlack_m + fastest_m_s * since_s;
  };
  // First: from the place last believed any leap is a hand's motion after a while.
  const bool is_there = leapt_ && is_near(*leapt_);
  if (!is_there && (!believed_ || is_near(*believed_))) return false;
  if (!is_there) leapt_at_ns_ = now_ns;
  leapt_ = place;
  return now_ns - leapt_at_ns_ < kLeapBelieved_ns;
}

std::optional<DeviceReading> DeviceReadingCheck::check(const stillgrid_device_state& state,
                                                       std::uint64_t now_ns) noexcept {
  const bool is_repeated = state.time_ns == stamp_ns_;
  reason_ = fault_of_pose(state);
  if (reason_ == 0) reason_ = fault_of_time(state, now_ns);
  if (reason_ != 0) return std::nullopt;
  stamp_ns_ = state.time_ns;

  const Place place{fresh_ns_, Eigen::Vector3d(state.position_m)};
  if (has_leapt(place, now_ns)) {
    reason_ = kFlagLeap;
    return std::nullopt;
  }
  believed_ = place;
  leapt_.reset();
  const bool is_recent = state.time_ns <= now_ns && now_ns - state.time_ns <= kRecent_ns;
  return DeviceReading{is_recent || is_repeated ? state.time_ns : now_ns, place.position_m,
                       orientation(state),
                       (state.valid & STILLGRID_STATE_BUTTONS) != 0 ? state.buttons : 0U};
}

}  // namespace stillgrid::safety
