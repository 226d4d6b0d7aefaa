#include "haptic_server/server.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <future>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "haptic_server/command_reader.hpp"
#include "haptic_server/device_life.hpp"
#include "haptic_server/last_stop.hpp"
#include "haptic_server/run.hpp"
#include "shared/publication/hands.hpp"
#include "shared/publication/relay_figures.hpp"
#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::haptic_server {
namespace {

constexpr std::uint64_t kScenePatience_ns = 10'000'000'000;
constexpr std::uint64_t kTellLoading_ns = 2'000'000'000;
constexpr std::uint64_t kAskHands_ns = 100'000'000;
constexpr auto kRecorderPatience = std::chrono::milliseconds(300);

/// "; another user has it: ...", where there is a session of that name; else empty.
std::string other_owner(const std::string& session) {
  const std::string ending = "/" + session;
  for (const publication::SegmentFile& file : publication::list_segments())
    if (file.kind == proto::SegmentKind::kScene && file.session.ends_with(ending))
      return "; another user has it: expected --session " + file.session;
  return "";
}

/// The scene, or null when stopped; throws when it does not come in time, not counting the time
/// that its sim_server loads.
const HandView* wait_for_scene(SceneWatch& watch, const HapticOptions& options,
                               const std::atomic<bool>& stop) {
  const std::uint64_t begin_ns = realtime::monotonic_ns();
  std::uint64_t alone_since_ns = begin_ns;
  std::uint64_t asked_ns = begin_ns;
  bool is_told = false;
  const auto is_loading = [](std::string_view session) {
    return publication::is_writer_loading(session, proto::SegmentKind::kScene);
  };
  const HandView* scene = nullptr;
  while ((scene = watch.acquire()) == nullptr && !stop) {
    watch.poll();
    const std::uint64_t now_ns = realtime::monotonic_ns();
    if (now_ns - asked_ns > kAskHands_ns) {
      publication::require_hand(options.session);
      asked_ns = now_ns;
    }
    if (is_loading(options.session) || is_loading(publication::session_of(options.session))) {
      alone_since_ns = now_ns;
      if (!is_told && now_ns - begin_ns > kTellLoading_ns)
        spdlog::info("waiting for sim_server, which is loading");
      is_told = is_told || now_ns - begin_ns > kTellLoading_ns;
    }
    if (now_ns - alone_since_ns > kScenePatience_ns)
      throw publication::SegmentError("no sim_server in session '" + options.session +
                                      "' after 10 s" + other_owner(options.session));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return scene;
}

/// What a recording tells of the run; of its device as far as the device told it.
recording::RecordingHead head_of(const HapticOptions& options, const HapticReport& report) {
  recording::RecordingHead head;
  const auto add = [&head](const char* key, const std::string& value) {
    if (!value.empty()) head.emplace_back(key, value);
  };
  add("device_serial", report.device_identity.serial);
  add("device_firmware", report.device_identity.firmware);
  add("device_driver", report.device_identity.driver);
  add("hand", std::string(publication::hand_of(options.session)));
  add("transition", std::string(report.transition));
  add("clock", options.lockstep ? "virtual" : "real time");
  add("stillgrid", options.version);
  return head;
}

/// In virtual time messages are stamped from 0, else by the time since 1970, as those of others.
recording::RecordingSource source_of(const HapticOptions& options) {
  if (options.lockstep) return {};
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  const auto now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(since_1970).count();
  return {.session = options.session,
          .clock_offset_ns = static_cast<std::uint64_t>(now_ns) - realtime::monotonic_ns()};
}

/// From open to close: the time in which a device may be stopped. Both of these calls are watched.
class OpenDevice {
 public:
  OpenDevice(device::Device& device, std::atomic<device::Device*>& open_device,
             safety::TickWatchdog& watchdog)
      : open_device_(open_device), watchdog_(watchdog) {
    watchdog_.rest();
    open_device_ = &device;
  }
  ~OpenDevice() {
    open_device_ = nullptr;
    // A stop is at most 300 ms; closed meanwhile the driver would use what it has freed.
    while (watchdog_.is_stopping()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    watchdog_.watch_call();
  }
  OpenDevice(const OpenDevice&) = delete;
  OpenDevice& operator=(const OpenDevice&) = delete;

 private:
  std::atomic<device::Device*>& open_device_;
  safety::TickWatchdog& watchdog_;
};

/// A disk may be slow.
void finish_recording(Run& run) {
  run.watchdog.rest();
  if (run.recorder != nullptr) run.report.lost_rows = run.recorder->finish();
}

/// Where the device cannot be waited for, neither can a disk.
void finish_recording_soon(recording::Recorder* recorder, HapticReport& report) {
  if (recorder == nullptr) return;
  std::promise<std::uint64_t> finished;
  auto lost_rows = finished.get_future();
  std::thread([recorder, finished = std::move(finished)]() mutable {
    finished.set_value(recorder->finish());
  }).detach();
  if (lost_rows.wait_for(kRecorderPatience) == std::future_status::ready)
    report.lost_rows = lost_rows.get();
}

/// Throws DeviceFault if more than half of the device's readings were not believed.
void require_believed(const HapticReport& report) {
  const std::uint64_t bad = report.flags[0];
  static_assert(safety::kFlagBadDevice == 1U);
  if (2 * bad <= report.ticks) return;
  throw DeviceFault("device '" + report.device + "': not believed in " + std::to_string(bad) +
                    " of " + std::to_string(report.ticks) +
                    " ticks; expected readings as device_check asks for");
}

/// The user learns what the chain holds a torque to where no driver says it.
void tell_undeclared_torque(const stillgrid_device_descriptor& device,
                            const safety::SafetyLimits& limits) {
  const bool has_motors = (device.flags & STILLGRID_DEVICE_NO_MOTORS) == 0;
  if (has_motors && device.max_force_N > 0.0 && device.max_torque_N_m == 0.0)
    spdlog::info("device '{}' declares no torque: none beyond {:.3g} N m, its force at {} m",
                 device.name, limits.max_force_N * limits.lever_m, limits.lever_m);
}

void run_and_release(Run& run) {
  std::exception_ptr fault;
  try {
    if (run.options.lockstep)
      run_lockstep(run);
    else
      run_real_time(run);
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
  if (const publication::SceneView* scene = run.watch.acquire(false))
    run.report.relay = publication::load_relay_figures(scene->reader().live());
  finish_recording(run);
  run.options.ended();
  if (fault) std::rethrow_exception(fault);
}

}  // namespace

void run_haptics(const HapticOptions& options, HapticReport& report, safety::GuardedState& guarded,
                 const std::atomic<bool>& stop) {
  const std::uint64_t period_ns = realtime::to_ns(1.0 / options.rate_hz);
  report.rate_hz = options.rate_hz;
  report.measures_time = !options.lockstep;
  const device::DeviceSpec spec = device::parse_device_spec(options.device);
  report.device = spec.plugin;
  const auto clock = options.lockstep ? proto::Clock::kVirtual : proto::Clock::kMonotonic;
  // Before the device is opened: a session that has a writer is no reason to touch one.
  auto lock = publication::SessionLock::take(options.session, proto::SegmentKind::kTool, stop);
  if (!lock) return;

  std::unique_ptr<recording::Recorder> recorder;
  std::atomic<recording::Recorder*> open_recorder = nullptr;
  const auto give_up = [&](const char* why) {
    finish_recording_soon(open_recorder, report);
    options.give_up("device '" + report.device + "': " + why);
  };
  static std::atomic<device::Device*> open_device =
      nullptr;                    // asked for up to the end of the process
  safety::TickWatchdog watchdog(  // outlives the device: each of its calls may hang
      period_ns,
      [] {
        if (device::Device* const device = open_device) device->emergency_stop();
      },
      [&] { give_up("a call did not return in time"); }, [&guarded] { safety::beat(guarded); });
  watchdog.watch_call();
  DriverWatch driver(spec.plugin);
  device::Device device(
      spec, {.period_ns = period_ns, .is_virtual = options.lockstep, .session = options.session});
  if (options.lockstep) require_no_motors(device, spec);
  if (options.safety.gripper_stiffness_N_per_m > 0.0) require_gripper(device, spec);
  const OpenDevice while_open(device, open_device, watchdog);
  stop_device_at_last(open_device, guarded, [&] { give_up("a call ended the program"); });
  report.device = device.descriptor().name;
  report.descriptor = device.descriptor();
  report.device_identity = device.identity();
  // A segment refused at the start ends the program; one refused later leaves the old one in use.
  bool is_waiting = true;
  SceneWatch watch(options.session, proto::SegmentKind::kScene, proto::kSceneLayoutHash, clock,
                   [&](const std::string& refusal) {
                     if (is_waiting) throw publication::SegmentError(refusal);
                     spdlog::warn("{}", refusal);
                   });
  const publication::SceneView* scene = wait_for_scene(watch, options, stop);
  is_waiting = false;
  if (scene == nullptr) return;
  report.scene = scene->scene().name.data();

  const safety::SafetyLimits limits = safety::safety_limits(options.safety, device.descriptor());
  const display::Transition shown =
      options.transition.value_or(rendering::default_transition(*scene, period_ns));
  report.transition = display::name_of(shown);
  if (!options.record.empty())
    recorder = std::make_unique<recording::Recorder>(options.record, report.scene, report.device,
                                                     head_of(options, report), source_of(options));
  // From here on a lockstep peer goes by this one, and is the first to say so if it ends.
  publication::ToolWriter tool(std::move(*lock), period_ns, clock,
                               options.lockstep ? 0 : realtime::monotonic_ns(), options.readers);
  tell_undeclared_torque(device.descriptor(), limits);
  const auto loop = std::make_unique<HapticLoop>(
      device, tool,
      rendering::make_renderer(options.transition.value_or(display::Transition::kLocal)), limits,
      period_ns, options.lockstep ? nullptr : realtime::monotonic_ns,
      options.transition ? nullptr : rendering::make_renderer(display::Transition::kHold));
  ToolOrders orders{.clutch_button = options.clutch_button};
  loop->obey(orders);
  open_recorder = recorder.get();
  Run run{options, report, stop,   period_ns,      device,   watch,
          tool,    *loop,  driver, recorder.get(), watchdog, guarded};
  std::optional<CommandReader> commands;
  if (!options.commands.empty()) commands.emplace(options.commands, device, orders);
  run_and_release(run);
  require_believed(report);
}

}  // namespace stillgrid::haptic_server
