#include <optional>
#include <thread>
#include <vector>

#include "shared/publication/segment.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "tests/soak/soak_processes.hpp"
#include "tests/soak/soak_snapshot.hpp"

namespace stillgrid::soak {

void write_snapshots(const SoakPlan& plan, SoakState& state) {
  publication::SegmentWriter writer(plan.session,
                                    {.kind = proto::SegmentKind::kScene,
                                     .layout_hash = kSoakLayoutHash,
                                     .period_ns = std::max(plan.spacing_ns, kSoakTick_ns),
                                     .clock = proto::Clock::kMonotonic,
                                     .start_ns = realtime::monotonic_ns(),
                                     .fixed_bytes = sizeof(proto::SegmentHeader),
                                     .payload_bytes = plan.bytes});
  writer.announce();
  std::vector<std::uint64_t> snapshot(plan.words());
  std::optional<realtime::PeriodicTimer> timer;
  if (plan.spacing_ns > 0) timer.emplace(plan.spacing_ns);
  const std::uint64_t last = plan.publications > 0 ? plan.publications : UINT64_MAX;
  for (std::uint64_t n = 1; n <= last && !state.writer_may_end; ++n) {
    fill_snapshot(snapshot, snapshot_base(writer.header().epoch, n));
    if (timer) timer->wait();
    const std::uint64_t began_ns = realtime::monotonic_ns();
    double_buffer::publish(writer.buffer(), n, {{0, snapshot}});
    state.publish_ns.record(realtime::monotonic_ns() - began_ns);
  }
  while (!state.writer_may_end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace stillgrid::soak
