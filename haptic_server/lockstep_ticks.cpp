#include <spdlog/spdlog.h>

#include "haptic_server/device_life.hpp"
#include "haptic_server/run.hpp"
#include "shared/publication/lockstep.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/realtime_thread.hpp"

namespace stillgrid::haptic_server {
namespace {

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

/// Waits until the samples of now_ns of the other hands' tools are complete. A hand that has ended
/// its run, or never comes to a simulation that has ended, is not waited for. False when stopped.
bool wait_for_tools(const Run& run, const HandView& scene, std::uint64_t now_ns) {
  const auto sample_ns = [](const publication::SegmentReader& of) {
    return double_buffer::HardwareAtomics::load(of.live().lockstep_sample_ns,
                                                std::memory_order_acquire);
  };
  for (const std::unique_ptr<ToolWatch>& watch : scene.watches()) {
    if (!watch) continue;
    const publication::ToolView* tool = nullptr;
    const auto word = [&] {
      const bool has_ended = sample_ns(scene.reader()) == proto::kNever;
      tool = watch->acquire();
      if (tool == nullptr && has_ended) {  // a tool that the simulation waited for is there by now
        watch->poll();
        tool = watch->acquire();
      }
      if (tool != nullptr) return sample_ns(tool->reader());
      return has_ended ? proto::kNever : 0;
    };
    const auto still_there = [&] {
      watch->poll();
      return tool != nullptr ? tool->reader().writer_alive() : scene.reader().writer_alive();
    };
    if (publication::wait_for_promise(word, now_ns + 1, still_there, run.stop) ==
        publication::WaitResult::kStopped)
      return false;
  }
  return true;
}

/// Returns when a run without --duration ends: a period after the last snapshot once the simulation
/// has promised never to publish again; else never.
std::uint64_t end_of_simulation_ns(const publication::SceneView& scene) {
  const proto::SegmentHeader& live = scene.reader().live();
  const auto load = [](const std::uint64_t& word) {
    return double_buffer::HardwareAtomics::load(word, std::memory_order_acquire);
  };
  if (load(live.lockstep_event_ns) != proto::kNever) return proto::kNever;
  return load(live.heartbeat_ns) + scene.header().period_ns;
}

/// The ticks of lockstep: docs/protocol.md, "Lockstep". The device's calls are watched, the waits
/// for a simulation are not: it may take its time, or be held in a debugger.
TickEnd tick_in_lockstep(Run& run, const HandView& scene) {
  using Header = proto::SegmentHeader;
  Header& own = run.tool.header();
  const std::uint64_t end_ns =
      run.options.duration_s ? realtime::to_ns(*run.options.duration_s) : proto::kNever;
  TickEnd end = TickEnd::kGoOn;
  recording::TickRow row;
  // The stop is read each tick: once the simulation has ended, no wait lasts long enough to see it.
  for (std::uint64_t now_ns = 0; now_ns < end_ns && end == TickEnd::kGoOn && !run.stop;
       now_ns += run.period_ns) {
    if (!wait_for(run, scene, &Header::lockstep_sample_ns, now_ns)) break;
    run.watchdog.watch_call();
    end = run.loop.sense(scene, now_ns);
    run.watchdog.rest();
    if (end != TickEnd::kGoOn) break;
    double_buffer::HardwareAtomics::store(own.lockstep_sample_ns, now_ns + run.period_ns,
                                          std::memory_order_release);
    if (!wait_for(run, scene, &Header::lockstep_event_ns, now_ns + 1)) break;
    if (!run.options.duration_s && now_ns >= end_of_simulation_ns(scene)) break;
    if (!wait_for_tools(run, scene, now_ns)) break;
    run.watchdog.watch_call();
    end = run.loop.act(scene, true, now_ns, row, scene.look_at_tools(), scene.local());
    run.watchdog.rest();
    if (run.recorder != nullptr) run.recorder->note_scene(scene);  // before it may go on
    double_buffer::HardwareAtomics::store(own.lockstep_event_ns, now_ns + run.period_ns,
                                          std::memory_order_release);
    run.loop.count(row, run.report);
    run.driver.note(row.flags);
    if (run.recorder != nullptr) run.recorder->record_waiting(row);
  }
  return end;
}

}  // namespace

void run_lockstep(Run& run) {
  activate(run);
  if (run.options.cpu && !realtime::pin_to_cpu(*run.options.cpu))
    spdlog::warn("running without processor {}", *run.options.cpu);
  const HandView& scene = *run.watch.acquire();
  const TickEnd end = tick_in_lockstep(run, scene);
  proto::SegmentHeader& own = run.tool.header();
  double_buffer::HardwareAtomics::store(own.lockstep_sample_ns, proto::kNever,
                                        std::memory_order_release);
  double_buffer::HardwareAtomics::store(own.lockstep_event_ns, proto::kNever,
                                        std::memory_order_release);
  if (end == TickEnd::kDeviceFault) throw_fault(run);
}

}  // namespace stillgrid::haptic_server
