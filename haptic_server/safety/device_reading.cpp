#include "haptic_server/safety/device_reading.hpp"

#include <cmath>

namespace stillgrid {
namespace {

constexpr double kFarthest_m = 10.0;
constexpr std::uint64_t kStale_ns = 100'000'000;
/// A sensor slower than that is followed tick by tick: its next sample may be long in coming.
constexpr std::uint64_t kRecent_ns = 10'000'000;
constexpr double kFastest_m_s = 20.0;
constexpr std::uint64_t kLeapBelieved_ns = 100'000'000;
/// Encoder steps and rounding, where two readings come in no time.
constexpr double kSlack_m = 1e-3;

bool has_position(const stillgrid_device_state& state) {
  const Eigen::Vector3d position_m(state.position_m);
  return (state.valid & STILLGRID_STATE_POSITION) != 0 && position_m.norm() <= kFarthest_m;
}

std::optional<Eigen::Quaterniond> orientation(const stillgrid_device_state& state) {
  const auto& xyzw = state.orientation_xyzw;
  const Eigen::Quaterniond q(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  if ((state.valid & STILLGRID_STATE_ORIENTATION) == 0 || !(std::abs(q.squaredNorm() - 1.0) < 1e-3))
    return std::nullopt;
  return q.normalized();
}

}  // namespace

std::optional<DeviceReading> DeviceReadingCheck::check(const stillgrid_device_state& state,
                                                       std::uint64_t now_ns) noexcept {
  if (!has_position(state)) return std::nullopt;
  const bool is_repeated = state.time_ns == stamp_ns_;
  const bool is_stale = state.time_ns + kStale_ns < now_ns || state.time_ns > now_ns + kStale_ns;
  if (state.time_ns < stamp_ns_ || is_stale) return std::nullopt;
  stamp_ns_ = state.time_ns;

  const Place place{now_ns, Eigen::Vector3d(state.position_m)};
  const auto is_near = [&place](const Place& before) {
    const double since_s = 1e-9 * static_cast<double>(place.tick_ns - before.tick_ns);
    return (place.position_m - before.position_m).norm() <= kSlack_m + kFastest_m_s * since_s;
  };
  // First: from the place last believed any leap is a hand's motion after a while.
  const bool has_leapt = leapt_ && is_near(*leapt_);
  if (has_leapt || (believed_ && !is_near(*believed_))) {
    if (!has_leapt) leapt_at_ns_ = now_ns;
    leapt_ = place;
    if (now_ns - leapt_at_ns_ < kLeapBelieved_ns) return std::nullopt;
  }
  believed_ = place;
  leapt_.reset();
  const bool is_recent = state.time_ns <= now_ns && now_ns - state.time_ns <= kRecent_ns;
  return DeviceReading{is_recent || is_repeated ? state.time_ns : now_ns, place.position_m,
                       orientation(state),
                       (state.valid & STILLGRID_STATE_BUTTONS) != 0 ? state.buttons : 0U};
}

}  // namespace stillgrid
