#include "shared/tools/scene_relay/ros_source.hpp"

#include <algorithm>

#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::scene_relay {

RosSource::RosSource(double rate_hz) noexcept : interval_ns_(realtime::to_ns(1.0 / rate_hz)) {}

bool RosSource::takes(const proto::SegmentHeader& segment, const proto::ToolState& state,
                      std::uint64_t now_ns) noexcept {
  if (!is_new(segment.epoch, state.tick)) return false;
  const bool is_sound = publication::has_sound_figures(state) && state.time_ns > last_time_ns_ &&
                        state.time_ns <= now_ns && now_ns - state.time_ns <= kOldest_ns;
  if (!is_sound) {
    ++counts_.refused;
    return false;
  }
  if (!is_due(state.time_ns, segment.period_ns)) {
    ++counts_.spared;
    return false;
  }
  last_time_ns_ = state.time_ns;
  ++counts_.taken;
  return true;
}

bool RosSource::is_new(std::uint64_t epoch, std::uint64_t tick) noexcept {
  if (epoch_ != epoch) {
    epoch_ = epoch;
    last_tick_ = tick - 1;  // what was before we came was not missed
  }
  if (tick <= last_tick_) return false;
  counts_.missed += tick - last_tick_ - 1;
  last_tick_ = tick;
  return true;
}

bool RosSource::is_due(std::uint64_t time_ns, std::uint64_t period_ns) noexcept {
  // A tick that comes a little early is the one that is meant; half a tick, or half an interval of
  // a segment that declares none that can be.
  const std::uint64_t early_ns = std::min(period_ns, interval_ns_) / 2;
  if (time_ns + early_ns < next_ns_) return false;
  next_ns_ = next_ns_ + interval_ns_ > time_ns ? next_ns_ + interval_ns_ : time_ns + interval_ns_;
  return true;
}

}  // namespace stillgrid::scene_relay
