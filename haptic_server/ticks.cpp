#include <spdlog/spdlog.h>

#include "haptic_server/device_life.hpp"
#include "haptic_server/run.hpp"
#include "shared/publication/lockstep.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/realtime_guard.hpp"
#include "shared/realtime/realtime_thread.hpp"

namespace stillgrid {
namespace {

TickEnd tick_in_real_time(Run& run) {
  RealtimeSection section;
  PeriodicTimer timer(run.period_ns);
  const std::uint64_t end_ns =
      run.options.duration_s ? monotonic_ns() + to_ns(*run.options.duration_s) : proto::kNever;
  TickEnd end = TickEnd::kGoOn;
  TickRow row;
  while (end == TickEnd::kGoOn) {
    section.begin_tick(run.report.ticks + 1);
    const PeriodicTimer::Wake wake = timer.wait();
    if ((run.stop || wake.now_ns >= end_ns) && run.loop.release()) break;
    if (run.watchdog.is_stopping()) continue;
    run.watchdog.tick();
    if (run.watchdog.stops() != run.report.device_stops) recover(run);
    run.tool.segment().require_whole();
    const SceneView& scene = *run.watch.acquire(run.loop.may_switch_scene());
    end = run.loop.sense(scene, wake.now_ns);
    if (end != TickEnd::kGoOn) break;
    end = run.loop.act(scene, run.watch.writer_alive(), wake.now_ns, row);
    row.tick_ns = monotonic_ns() - wake.now_ns;
    run.report.missed_ticks += wake.skipped > 0 ? 1 : 0;
    run.report.wake_ns.record(wake.now_ns - wake.deadline_ns);
    run.loop.note_times(row.tick_ns, wake.now_ns - wake.deadline_ns, run.report.missed_ticks);
    run.loop.count(row, run.report);
    run.driver.note(row.flags);
    if (run.recorder != nullptr) run.recorder->record(row);
  }
  return end;
}

/// False when stopped.
bool wait_for(Run& run, const SceneView& scene, std::uint64_t proto::SegmentHeader::*promise,
              std::uint64_t value) {
  const auto word = [&] {
    return HardwareAtomics::load(scene.reader().live().*promise, std::memory_order_acquire);
  };
  const auto still_there = [&] { return scene.reader().writer_alive(); };
  const WaitResult result = wait_for_promise(word, value, still_there, run.stop);
  if (result == WaitResult::kPeerGone)
    throw SegmentError("the sim_server died; lockstep cannot go on without it");
  return result == WaitResult::kReached;
}

/// The ticks of lockstep: docs/protocol.md, "Lockstep".
TickEnd tick_in_lockstep(Run& run, const SceneView& scene) {
  using Header = proto::SegmentHeader;
  Header& own = run.tool.header();
  const std::uint64_t end_ns =
      run.options.duration_s ? to_ns(*run.options.duration_s) : proto::kNever;
  TickEnd end = TickEnd::kGoOn;
  TickRow row;
  for (std::uint64_t now_ns = 0; now_ns < end_ns && end == TickEnd::kGoOn;
       now_ns += run.period_ns) {
    if (!wait_for(run, scene, &Header::lockstep_sample_ns, now_ns)) break;
    end = run.loop.sense(scene, now_ns);
    if (end != TickEnd::kGoOn) break;
    HardwareAtomics::store(own.lockstep_sample_ns, now_ns + run.period_ns,
                           std::memory_order_release);
    if (!wait_for(run, scene, &Header::lockstep_event_ns, now_ns + 1)) break;
    end = run.loop.act(scene, true, now_ns, row);
    HardwareAtomics::store(own.lockstep_event_ns, now_ns + run.period_ns,
                           std::memory_order_release);
    run.loop.count(row, run.report);
    run.driver.note(row.flags);
    if (run.recorder != nullptr) run.recorder->record_waiting(row);
  }
  return end;
}

}  // namespace

void run_real_time(Run& run) {
  run.watch.start();
  for (const std::string& missing : make_realtime(run.options.cpu))
    spdlog::warn("running without {}", missing);
  run.watchdog.watch_ticks();
  const long faults_before = page_faults();
  const TickEnd end = tick_in_real_time(run);
  run.report.page_faults = page_faults() - faults_before;
  if (end == TickEnd::kDeviceFault) throw_fault(run);
}

void run_lockstep(Run& run) {
  if (run.options.cpu && !pin_to_cpu(*run.options.cpu))
    spdlog::warn("running without processor {}", *run.options.cpu);
  const SceneView& scene = *run.watch.acquire();
  const TickEnd end = tick_in_lockstep(run, scene);
  proto::SegmentHeader& own = run.tool.header();
  HardwareAtomics::store(own.lockstep_sample_ns, proto::kNever, std::memory_order_release);
  HardwareAtomics::store(own.lockstep_event_ns, proto::kNever, std::memory_order_release);
  if (end == TickEnd::kDeviceFault) throw_fault(run);
}

}  // namespace stillgrid
