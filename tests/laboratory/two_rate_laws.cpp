#include "tests/laboratory/two_rate_laws.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace stillgrid::laboratory::two_rate {
namespace {

/// Periods after which a law's memory has settled, or never will.
constexpr int kSettling = 200;
constexpr std::uint64_t kTick_ns = 1'000'000;

/// The stamps of snapshot `number` of a regular stream.
proto::SnapshotHeader stamps(int number, int period_ticks, int latency_ticks) {
  proto::SnapshotHeader header{};
  header.snapshot_id = static_cast<std::uint64_t>(number);
  header.history_count = std::min<std::uint64_t>(header.snapshot_id, proto::kHistoryLength);
  header.prediction_ns = static_cast<std::uint64_t>(period_ticks) * kTick_ns;
  for (std::size_t i = 0; i < proto::kHistoryLength; ++i) {
    const std::uint64_t snapshot =
        header.snapshot_id - std::min<std::uint64_t>(i, header.history_count - 1);
    header.state_time_ns[i] = snapshot * header.prediction_ns;
    header.publish_time_ns[i] =
        header.state_time_ns[i] + static_cast<std::uint64_t>(latency_ticks) * kTick_ns;
  }
  header.tool_time_ns = header.state_time_ns[0];
  return header;
}

}  // namespace

Cycle cycle_of(display::Transition transition, int period_ticks, int latency_ticks) {
  display::TransitionMemory memory = display::at_first_snapshot();
  proto::SnapshotHeader shown = stamps(1, period_ticks, latency_ticks);
  for (int number = 2; number <= kSettling; ++number) {
    const proto::SnapshotHeader next = stamps(number, period_ticks, latency_ticks);
    memory = display::after_switch(transition, memory, shown, next);
    shown = next;
  }
  Cycle cycle;
  for (int ticks = 0; ticks < period_ticks; ++ticks)
    cycle.push_back(display::snapshot_weights(
        transition, memory, shown,
        shown.publish_time_ns[0] + static_cast<std::uint64_t>(ticks) * kTick_ns));
  return cycle;
}

Cycle cycle_of(const Law& law, int period_ticks) {
  display::SnapshotWeights at_switch;
  at_switch.position[1] = 1.0;
  for (int i = 0; i < kSettling; ++i)
    at_switch = display::in_later_snapshot(law(period_ticks, period_ticks, at_switch), 1);
  Cycle cycle;
  for (int ticks = 0; ticks < period_ticks; ++ticks)
    cycle.push_back(law(ticks, period_ticks, at_switch));
  return cycle;
}

Cycle constraints_cycle(int period_ticks) {
  display::SnapshotWeights newest;
  newest.position[0] = 1.0;
  newest.step_share = 1.0;
  return Cycle(static_cast<std::size_t>(period_ticks), newest);
}

Law ramp(double share, double most_ticks) {
  return
      [share, most_ticks](int ticks, int period_ticks, const display::SnapshotWeights& at_switch) {
        const double length_ticks = std::min(share * period_ticks, most_ticks);
        const double progress = std::min(1.0, (ticks + 1) / length_ticks);
        display::SnapshotWeights displayed = at_switch;
        for (double& weight : displayed.position) weight *= 1.0 - progress;
        for (double& time_s : displayed.velocity_s) time_s *= 1.0 - progress;
        displayed.position[0] += progress;
        return displayed;
      };
}

}  // namespace stillgrid::laboratory::two_rate
