#include "haptic_server/server.hpp"

#include <spdlog/spdlog.h>

#include <exception>
#include <future>
#include <memory>
#include <thread>
#include <utility>

#include "haptic_server/driver_watch.hpp"
#include "haptic_server/haptic_loop.hpp"
#include "haptic_server/last_stop.hpp"
#include "haptic_server/safety/tick_watchdog.hpp"
#include "shared/publication/lockstep.hpp"
#include "shared/publication/segment_watch.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/realtime_guard.hpp"
#include "shared/realtime/realtime_thread.hpp"

namespace stillgrid {
namespace {

constexpr std::uint64_t kScenePatience_ns = 10'000'000'000;
constexpr auto kRecorderPatience = std::chrono::milliseconds(300);

using SceneWatch = SegmentWatch<SceneView>;

/// The scene, or null when stopped; throws when it does not come in time.
const SceneView* wait_for_scene(SceneWatch& watch, const HapticOptions& options,
                                const std::atomic<bool>& stop) {
  const std::uint64_t give_up_ns = monotonic_ns() + kScenePatience_ns;
  const SceneView* scene = nullptr;
  while ((scene = watch.acquire()) == nullptr && !stop) {
    watch.poll();
    if (monotonic_ns() > give_up_ns)
      throw SegmentError("no sim_server in session '" + options.session + "' after 10 s");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return scene;
}

/// What a recording tells of its device, as far as the device told it.
RecordingHead head_of(const DeviceIdentity& device) {
  RecordingHead head;
  const auto add = [&head](const char* key, const std::string& value) {
    if (!value.empty()) head.emplace_back(key, value);
  };
  add("device_serial", device.serial);
  add("device_firmware", device.firmware);
  add("device_driver", device.driver);
  return head;
}

/// Everything one run needs, made before the loop starts.
struct Run {
  const HapticOptions& options;
  HapticReport& report;
  const std::atomic<bool>& stop;
  std::uint64_t period_ns;
  Device& device;
  SceneWatch& watch;
  ToolWriter& tool;
  HapticLoop& loop;
  DriverWatch& driver;
  Recorder* recorder;
  TickWatchdog& watchdog;
  GuardedState& guarded;
};

[[noreturn]] void throw_fault(Run& run) {
  run.device.emergency_stop();
  throw DeviceFault("device '" + run.report.device +
                    "': " + run.device.error_line(run.loop.device_code()));
}

bool has_motors(const Device& device) {
  return (device.descriptor().flags & STILLGRID_DEVICE_NO_MOTORS) == 0;
}

/// Virtual time stands still for as long as the simulation takes, and a force with it.
void require_no_motors(const Device& device, const DeviceSpec& spec) {
  if (has_motors(device))
    throw DeviceError(DeviceFailure::kBadInput,
                      "device '" + spec.plugin +
                          "': --lockstep: expected a device that declares "
                          "STILLGRID_DEVICE_NO_MOTORS (simulated, recorded or input alone): in "
                          "virtual time nothing watches over a force");
}

/// What a deactivate that failed left behind may be a force: stopped here, and by the guardian once
/// more when this process is gone.
void deactivate(Run& run) {
  if (!run.device.is_active()) return;
  run.watchdog.watch_release();
  const std::int32_t code = run.device.deactivate();
  if (code != STILLGRID_DEVICE_OK) {
    const std::string line = run.device.error_line(code);
    run.device.emergency_stop();
    throw DeviceFault("device '" + run.report.device + "': deactivate: " + line);
  }
  run.guarded.has_motors = false;
}

void activate(Run& run) {
  run.watchdog.watch_call();
  run.guarded.has_motors = has_motors(run.device);
  try {
    run.device.activate();
  } catch (...) {
    run.device.emergency_stop();
    run.guarded.has_motors = false;  // as the driver says
    throw;
  }
}

/// The watchdog has stopped the device, and the loop is back: no force, then a ramp. Not for ever.
void recover(Run& run) {
  constexpr std::uint64_t kMostStops = 3;
  const std::uint64_t stops = run.report.device_stops = run.watchdog.stops();
  spdlog::warn("no tick for 100 ms or more: the device was stopped");
  if (stops >= kMostStops)
    throw DeviceFault("device '" + run.report.device + "': stopped " + std::to_string(stops) +
                      " times for want of ticks; expected calls that return in time");
  deactivate(run);
  activate(run);
  run.loop.cut();
  run.watchdog.watch_ticks();
}

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

void run_real(Run& run) {
  run.watch.start();
  for (const std::string& missing : make_realtime(run.options.cpu))
    spdlog::warn("running without {}", missing);
  run.watchdog.watch_ticks();
  const long faults_before = page_faults();
  const TickEnd end = tick_in_real_time(run);
  run.report.page_faults = page_faults() - faults_before;
  if (end == TickEnd::kDeviceFault) throw_fault(run);
}

/// From open to close: the time in which a device may be stopped. Both of these calls are watched.
class OpenDevice {
 public:
  OpenDevice(Device& device, std::atomic<Device*>& open_device, TickWatchdog& watchdog)
      : open_device_(open_device), watchdog_(watchdog) {
    watchdog_.rest();
    open_device_ = &device;
  }
  ~OpenDevice() {
    open_device_ = nullptr;
    watchdog_.watch_call();
  }
  OpenDevice(const OpenDevice&) = delete;
  OpenDevice& operator=(const OpenDevice&) = delete;

 private:
  std::atomic<Device*>& open_device_;
  TickWatchdog& watchdog_;
};

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

/// Motors off before anything else takes its time to end. A force that no tick could fade is cut.
void release(Run& run) {
  if (!run.options.lockstep && !run.loop.release()) run.device.emergency_stop();
  deactivate(run);
}

/// A disk may be slow.
void finish_recording(Run& run) {
  run.watchdog.rest();
  if (run.recorder != nullptr) run.report.lost_rows = run.recorder->finish();
}

/// Where the device cannot be waited for, neither can a disk.
void finish_recording_soon(Recorder* recorder, HapticReport& report) {
  if (recorder == nullptr) return;
  std::promise<std::uint64_t> finished;
  auto lost_rows = finished.get_future();
  std::thread([recorder, finished = std::move(finished)]() mutable {
    finished.set_value(recorder->finish());
  }).detach();
  if (lost_rows.wait_for(kRecorderPatience) == std::future_status::ready)
    report.lost_rows = lost_rows.get();
}

/// A run whose device was hardly ever believed has not run.
void require_believed(const HapticReport& report) {
  constexpr double kMost = 0.9;
  const std::uint64_t bad = report.flags[0];
  static_assert(kFlagBadDevice == 1U);
  if (bad == 0 || static_cast<double>(bad) < kMost * static_cast<double>(report.ticks)) return;
  throw DeviceFault("device '" + report.device + "': not believed in " + std::to_string(bad) +
                    " of " + std::to_string(report.ticks) +
                    " ticks; expected readings as device_check asks for");
}

/// The user learns what the chain holds a torque to where no driver says it.
void tell_undeclared_torque(const stillgrid_device_descriptor& device, const SafetyLimits& limits) {
  if (device.max_force_N > 0.0 && device.max_torque_N_m == 0.0)
    spdlog::info("device '{}' declares no torque: none beyond {:.3g} N m, its force at {} m",
                 device.name, limits.max_force_N * limits.lever_m, limits.lever_m);
}

void run_and_release(Run& run) {
  std::exception_ptr fault;
  try {
    activate(run);
    if (run.options.lockstep)
      run_lockstep(run);
    else
      run_real(run);
  } catch (...) {
    fault = std::current_exception();
    run.device.emergency_stop();
  }
  try {
    release(run);
  } catch (const DeviceFault& error) {
    if (fault)
      spdlog::warn("{}", error.what());
    else
      fault = std::current_exception();
  }
  finish_recording(run);
  run.options.ended();
  if (fault) std::rethrow_exception(fault);
}

}  // namespace

void run_haptics(const HapticOptions& options, HapticReport& report, GuardedState& guarded,
                 const std::atomic<bool>& stop) {
  const std::uint64_t period_ns = to_ns(1.0 / options.rate_hz);
  report.rate_hz = options.rate_hz;
  report.measures_time = !options.lockstep;
  report.transition = name_of(options.transition);
  report.model = name_of(options.model);
  const DeviceSpec spec = parse_device_spec(options.device);
  report.device = spec.plugin;

  std::unique_ptr<Recorder> recorder;
  std::atomic<Recorder*> open_recorder = nullptr;
  const auto give_up = [&](const char* why) {
    finish_recording_soon(open_recorder, report);
    options.give_up("device '" + report.device + "': " + why);
  };
  static std::atomic<Device*> open_device = nullptr;  // asked for up to the end of the process
  TickWatchdog watchdog(  // outlives the device: each of its calls may hang
      period_ns,
      [] {
        if (Device* const device = open_device) device->emergency_stop();
      },
      [&] { give_up("a call did not return in time"); },
      [&guarded] { guarded.beats.fetch_add(1, std::memory_order_relaxed); });
  watchdog.watch_call();
  DriverWatch driver(spec.plugin);
  Device device(spec, {.period_ns = period_ns, .is_virtual = options.lockstep});
  if (options.lockstep) require_no_motors(device, spec);
  const OpenDevice while_open(device, open_device, watchdog);
  stop_device_at_last(open_device, guarded, [&] { give_up("a call ended the program"); });
  report.device = device.descriptor().name;
  report.device_identity = device.identity();
  // A segment refused at the start ends the program; one refused later leaves the old one in use.
  bool is_waiting = true;
  const auto clock = options.lockstep ? proto::Clock::kVirtual : proto::Clock::kMonotonic;
  SceneWatch watch(options.session, proto::SegmentKind::kScene, proto::kSceneLayoutHash, clock,
                   [&](const std::string& refusal) {
                     if (is_waiting) throw SegmentError(refusal);
                     spdlog::warn("{}", refusal);
                   });
  const SceneView* scene = wait_for_scene(watch, options, stop);
  is_waiting = false;
  if (scene == nullptr) return;
  report.scene = scene->scene().name.data();

  ToolWriter tool(options.session, period_ns, clock, options.lockstep ? 0 : monotonic_ns(),
                  options.readers);
  if (!options.record.empty())
    recorder = std::make_unique<Recorder>(options.record, report.scene, report.device,
                                          head_of(device.identity()));
  const SafetyLimits limits = safety_limits(options.safety, device.descriptor());
  tell_undeclared_torque(device.descriptor(), limits);
  const auto loop =
      std::make_unique<HapticLoop>(device, tool, make_renderer(options.model, options.transition),
                                   limits, period_ns, options.lockstep ? nullptr : monotonic_ns);
  open_recorder = recorder.get();
  Run run{options, report, stop,   period_ns,      device,   watch,
          tool,    *loop,  driver, recorder.get(), watchdog, guarded};
  run_and_release(run);
  require_believed(report);
}

}  // namespace stillgrid
