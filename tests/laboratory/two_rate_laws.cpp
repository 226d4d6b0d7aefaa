#include "tests/laboratory/two_rate_laws.hpp"

#include <cstdint>

namespace stillgrid::laboratory::two_rate {

Cycle cycle_of(display::Transition transition, int period_ticks, int latency_ticks) {
  constexpr std::uint64_t kTick_ns = 1'000'000;
  const auto ticks_ns = [](int ticks) { return static_cast<std::uint64_t>(ticks) * kTick_ns; };
  proto::SnapshotHeader shown{};
  shown.snapshot_id = shown.history_count = proto::kHistoryLength;
  shown.state_time_ns = {ticks_ns(2 * period_ticks), ticks_ns(period_ticks)};
  for (std::size_t i = 0; i < proto::kHistoryLength; ++i)
    shown.publish_time_ns[i] = shown.state_time_ns[i] + ticks_ns(latency_ticks);
  Cycle cycle;
  for (int tick = 0; tick < period_ticks; ++tick)
    cycle.push_back(
        display::snapshot_weights(transition, shown, shown.publish_time_ns[0] + ticks_ns(tick)));
  return cycle;
}

}  // namespace stillgrid::laboratory::two_rate
