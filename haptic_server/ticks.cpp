#include <spdlog/spdlog.h>

#include "haptic_server/device_life.hpp"
#include "haptic_server/run.hpp"
#include "shared/publication/lockstep.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/realtime_guard.hpp"
#include "shared/realtime/realtime_thread.hpp"

namespace stillgrid::haptic_server {
namespace {

TickEnd tick_in_real_time(Run& run) {
  realtime::RealtimeSection section;
  realtime::PeriodicTimer timer(run.period_ns);
  const std::uint64_t end_ns =
      run.options.duration_s ? realtime::monotonic_ns() + realtime::to_ns(*run.options.duration_s)
                             : proto::kNever;
  TickEnd end = TickEnd::kGoOn;
  recording::TickRow row;
  while (end == TickEnd::kGoOn) {
    section.begin_tick(run.report.ticks + 1);
    const realtime::PeriodicTimer::Wake wake = timer.wait();
    if ((run.stop || wake.now_ns >= end_ns) && run.loop.release()) break;
    if (run.watchdog.is_stopping()) continue;
    run.watchdog.tick();
    if (run.watchdog.stops() != run.report.device_stops) recover(run);
    run.tool.segment().require_whole();
    const publication::SceneView& scene = *run.watch.acquire(run.loop.may_switch_scene());
    end = run.loop.sense(scene, wake.now_ns);
    if (end != TickEnd::kGoOn) break;
    end = run.loop.act(scene, run.watch.writer_alive(), wake.now_ns, row);
    row.tick_ns = realtime::monotonic_ns() - wake.now_ns;
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
bool wait_for(Run& run, const publication::SceneView& scene,
              std::uint64_t proto::SegmentHeader::*promise, std::uint64_t value) {
  const auto word = [&] {
    return double_buffer::HardwareAtomics::load(scene.reader().live().*promise,
                                                std::memory_order_acquire);
  };
  const auto still_there = [&] { return scene.reader().writer_alive(); };
  const publication::WaitResult result =
      publication::wait_for_promise(word, value, still_there, run.stop);
  if (result == publication::WaitResult::kPeerGone)
    throw publication::SegmentError("the sim_server died; lockstep cannot go on without it");
  return result == publication::WaitResult::kReached;
}

/// The ticks of lockstep: docs/protocol.md, "Lockstep". The device's calls are watched, the waits
/// for a simulation are not: it may take its time, or be held in a debugger.
TickEnd tick_in_lockstep(Run& run, const publication::SceneView& scene) {
  using Header = proto::SegmentHeader;
  Header& own = run.tool.header();
  const std::uint64_t end_ns =
      run.options.duration_s ? realtime::to_ns(*run.options.duration_s) : proto::kNever;
  TickEnd end = TickEnd::kGoOn;
  recording::TickRow row;
  for (std::uint64_t now_ns = 0; now_ns < end_ns && end == TickEnd::kGoOn;
       now_ns += run.period_ns) {
    if (!wait_for(run, scene, &Header::lockstep_sample_ns, now_ns)) break;
    run.watchdog.watch_call();
    end = run.loop.sense(scene, now_ns);
    run.watchdog.rest();
    if (end != TickEnd::kGoOn) break;
    double_buffer::HardwareAtomics::store(own.lockstep_sample_ns, now_ns + run.period_ns,
                                          std::memory_order_release);
    if (!wait_for(run, scene, &Header::lockstep_event_ns, now_ns + 1)) break;
    run.watchdog.watch_call();
    end = run.loop.act(scene, true, now_ns, row);
    run.watchdog.rest();
    double_buffer::HardwareAtomics::store(own.lockstep_event_ns, now_ns + run.period_ns,
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
  for (const std::string& missing : realtime::make_realtime(run.options.cpu))
    spdlog::warn("running without {}", missing);
  run.watchdog.watch_ticks();
  const long faults_before = realtime::page_faults();
  const TickEnd end = tick_in_real_time(run);
  run.report.page_faults = realtime::page_faults() - faults_before;
  if (end == TickEnd::kDeviceFault) throw_fault(run);
}

void run_lockstep(Run& run) {
  if (run.options.cpu && !realtime::pin_to_cpu(*run.options.cpu))
    spdlog::warn("running without processor {}", *run.options.cpu);
  const publication::SceneView& scene = *run.watch.acquire();
  const TickEnd end = tick_in_lockstep(run, scene);
  proto::SegmentHeader& own = run.tool.header();
  double_buffer::HardwareAtomics::store(own.lockstep_sample_ns, proto::kNever,
                                        std::memory_order_release);
  double_buffer::HardwareAtomics::store(own.lockstep_event_ns, proto::kNever,
                                        std::memory_order_release);
  if (end == TickEnd::kDeviceFault) throw_fault(run);
}

}  // namespace stillgrid::haptic_server
