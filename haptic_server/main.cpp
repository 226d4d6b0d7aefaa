#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "haptic_server/device/list_devices.hpp"
#include "haptic_server/device/release_device.hpp"
#include "haptic_server/recording/recorder.hpp"
#include "haptic_server/safety/guardian.hpp"
#include "haptic_server/server.hpp"
#include "shared/command_line/file_name.hpp"
#include "shared/command_line/number_in.hpp"
#include "shared/command_line/prepare_daemon.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/publication/hands.hpp"
#include "shared/publication/segment.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/realtime_guard.hpp"
#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::haptic_server {
namespace {

struct Arguments {
  HapticOptions options;
  std::string hand;               // empty: the only one
  std::string transition, group;  // empty: by the scene; none
  std::filesystem::path report;
  bool realtime_guard = false;
};

constexpr const char* kDescription =
    "Computes the force of a session's snapshots on a device, at 1 kHz.\n"
    "\n"
    "  haptic_server --session demo --device phantom:path=press,hand=light --record run.csv\n"
    "  haptic_server --session ci --lockstep --device replay:file=run.csv --record again.csv\n"
    "  haptic_server --session demo --hand left --device phantom           one of each hand\n"
    "  haptic_server --session demo --device mouse          the mouse of a page of scene_viewer\n"
    "\n"
    "A device is the path of a plugin (.so) or the name of an installed one, as phantom:\n"
    "--list-devices prints them, and what they see.\n";

void add_options(CLI::App& app, Arguments& arguments) {
  HapticOptions& options = arguments.options;
  app.add_option("--session", options.session,
                 "Name that joins the two servers; USER/NAME: with USER's")
      ->required()
      ->transform(CLI::Validator(publication::settle_session, ""));
  app.add_option("--hand", arguments.hand, "Of a scene that names its hands: which")
      ->check(publication::hand_complaint);
  app.add_option("--device", options.device,
                 "PLUGIN[@N][:key=value,...], N from 0: which of a driver's devices")
      ->required();
  app.add_flag_callback(
      "--list-devices",
      [&options] {
        throw CLI::RuntimeError(options.device.empty() ? device::print_installed_devices()
                                                       : device::print_devices(options.device));
      },
      "Print the devices that installed drivers see, or with --device those of that one, and what "
      "to give --device for each; then end");
  app.add_option("--rate", options.rate_hz, "Ticks a second, Hz; default 1000")
      ->check(command_line::number_in(10.0, 1e4));
  std::vector<std::string> names;
  std::string remarks;
  for (const display::TransitionLaw& law : display::transitions()) {
    names.emplace_back(law.name);
    remarks += "; " + names.back() + ": " + std::string(law.remark);
  }
  app.add_option("--transition", arguments.transition,
                 "How the scene goes on between snapshots; default: local" + remarks)
      ->check(CLI::IsMember(names));
  app.add_option(
         "--record", options.record,
         "Record every tick: FILE.mcap for Foxglove and PlotJuggler, with the scene; else CSV")
      ->check(recording::name_complaint);
  app.add_option("--duration", options.duration_s,
                 "Time to run, s; default: until Ctrl-C or the end of a replay")
      ->check(command_line::number_in(1e-6, 1e8));
  app.add_flag("--lockstep", options.lockstep,
               "Virtual time, in agreement with sim_server --lockstep; repeatable to the bit");
  app.add_option("--report", arguments.report, "Write a report (JSON) at exit");
  app.add_option("--cpu", options.cpu, "Run the loop on this processor")
      ->check(command_line::integer_in(0, 8191));
  app.add_option("--commands", options.commands,
                 "Obey, while ticks go on, the orders that come in this file or named pipe, a line "
                 "KEY=VALUE each: tool.clutch=on or off, tool.scale=0.5; others go to the driver")
      ->check(command_line::file_name())
      ->excludes("--lockstep");
  app.add_option("--clutch-button", options.clutch_button,
                 "While this button of the device is down the tool stays, without a force, and the "
                 "device can be moved to a better place; from 0")
      ->check(command_line::integer_in(0, 31))
      ->type_name("N");
  app.add_option("--gripper-stiffness", options.safety.gripper_stiffness_N_per_m,
                 "Open a device's gripper by a spring, N/m; default 0: no force on its fingers")
      ->check(command_line::number_in(0.0, 1e6));
  app.add_option("--reopen", options.reopenings,
                 "Open a device that was lost again, a second apart, up to N times in the run; the "
                 "force then ramps in from zero; default 0: end with status 3")
      ->check(command_line::integer_in(0, 100000))
      ->type_name("N")
      ->excludes("--lockstep");
  app.add_option("--group", arguments.group,
                 "Let this group of users read the session too; default: only its owner")
      ->check(publication::group_complaint);
  app.add_option("--max-force", options.safety.max_force_N,
                 "Limit of the force, N; default and upper bound: the device's own")
      ->check(command_line::number_in(1e-6, 1e4));
  app.add_option("--max-slew", options.safety.max_slew_N_per_ms,
                 "Limit of the force's growth and turn, N/ms; default: a tenth of its limit in a "
                 "millisecond; its norm may fall at once")
      ->check(command_line::number_in(1e-9, 1e6));
  app.add_option("--max-stiffness", options.safety.max_stiffness_N_per_m,
                 "Limit of the stiffness of all contacts together, N/m; default: what the device "
                 "declares")
      ->check(command_line::number_in(1e-3, 1e9));
  app.add_option("--max-speed", options.safety.max_speed_m_s,
                 "Speed above which the force no longer drives the device, m/s; default: what the "
                 "device declares")
      ->check(command_line::number_in(1e-3, 1e3));
  app.add_option("--passivity-control", options.safety.passivity_mass_kg,
                 "Damp away the energy that the held force gives. KG: apparent mass of the device "
                 "with the hand, which the damper stops in no less than a tick; default: off")
      ->check(command_line::number_in(1e-4, 100.0))
      ->type_name("KG");
  app.add_flag("--realtime-guard", arguments.realtime_guard,
               "Test mode: counts and names every call of the 1 kHz loop that may block; exit "
               "status 4 if there was one")
      ->excludes("--lockstep");
}

int fail(const std::exception& error, int status) {
  std::fprintf(stderr, "haptic_server: %s\n", error.what());
  return status;
}

/// A line a call. Returns the exit status.
int name_violations(const std::vector<realtime::RealtimeViolation>& violations) {
  for (const realtime::RealtimeViolation& violation : violations)
    spdlog::error("real-time violation: {}, {} times, first from {} at tick {}", violation.call,
                  violation.count, violation.first_caller, violation.first_tick);
  return violations.empty() ? realtime::kDone : realtime::kRealtimeViolation;
}

/// Runs the loop; the report is written however it ended.
int run(Arguments& arguments, safety::GuardedState& guarded) {
  HapticReport report;
  int status = realtime::kDone, report_status = realtime::kDone;
  const auto finish_report = [&] {
    try {
      if (!arguments.report.empty() && (report.ticks > 0 || report.device_stops > 0))
        write_report(report, arguments.report);
    } catch (const std::exception& error) {
      report_status = fail(error, realtime::kBadInput);
    }
  };
  arguments.options.ended = [&] {
    if (report.lost_rows > 0)
      spdlog::error("--record: {}: {} of {} ticks are missing", arguments.options.record.string(),
                    report.lost_rows, report.ticks);
    if (arguments.realtime_guard) report.realtime_violations = realtime::realtime_violations();
    finish_report();
  };
  // The loop stands still, in a driver's call or told to, and counts nothing.
  arguments.options.give_up = [&](const std::string& line) {
    std::fprintf(stderr, "haptic_server: %s\n", line.c_str());
    finish_report();
    guarded.end_status = realtime::kDeviceFault;
    std::_Exit(realtime::kDeviceFault);
  };
  if (!arguments.report.empty()) files::require_writable(arguments.report);
  try {
    run_haptics(arguments.options, report, guarded, realtime::stop_requested());
  } catch (const device::DeviceError& error) {
    status = fail(error, error.exit_status());
  } catch (const DeviceFault& error) {
    status = fail(error, realtime::kDeviceFault);
  } catch (const publication::SegmentError& error) {
    status = fail(error, realtime::kCouldNotStart);
  }
  if (report.realtime_violations) {
    const int verdict = name_violations(*report.realtime_violations);
    if (status == realtime::kDone) status = verdict;
  }
  if (const int number = realtime::rare_stop_signal(); number != 0 && status == realtime::kDone) {
    spdlog::error("ended by signal {} ({})", number, ::strsignal(number));
    status = realtime::kSignalled + number;
  }
  if (status == realtime::kDone && report.lost_rows > 0) status = realtime::kIncomplete;
  return status == realtime::kDone ? report_status : status;
}

/// A file that the device is given, as a trajectory, is not recorded over.
void require_another_file(const std::filesystem::path& record, const device::DeviceSpec& spec) {
  std::error_code ignored;
  for (const device::DeviceOption& option : spec.options)
    if (!record.empty() && std::filesystem::equivalent(option.value, record, ignored))
      throw std::runtime_error("--record: value '" + record.string() +
                               "': expected another file than the device's " + option.key +
                               ", which is read");
}

safety::GuardedProgram program_of(Arguments& arguments) {
  const device::DeviceSpec spec = device::parse_device_spec(arguments.options.device);
  require_another_file(arguments.options.record, spec);
  const device::DeviceLoop loop{.period_ns = realtime::to_ns(1.0 / arguments.options.rate_hz),
                                .session = arguments.options.session};
  safety::GuardedProgram program;
  program.subject = "device '" + spec.plugin + "'";
  program.work = [&arguments](safety::GuardedState& guarded) {
    realtime::share_stop(guarded.stop);
    command_line::prepare_daemon("haptic_server");
    realtime::install_rare_stop_signals();
    try {
      return run(arguments, guarded);
    } catch (const std::exception& error) {
      return fail(error, realtime::kBadInput);
    }
  };
  for (const device::ReleaseWay way :
       {device::ReleaseWay::kEveryCall, device::ReleaseWay::kStopAlone,
        device::ReleaseWay::kWithoutStop})
    program.releases.emplace_back([spec, loop, way] { device::release_device(spec, loop, way); });
  return program;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "haptic_server");
  Arguments arguments;
  add_options(app, arguments);
  command_line::add_version(app,
                            {command_line::segment_interface(), command_line::device_interface()});
  return command_line::run_program(app, argc, argv, [&] {
    if (arguments.realtime_guard) realtime::require_realtime_guard(argv);
    arguments.options.session =
        publication::hand_session(arguments.options.session, arguments.hand);
    arguments.options.version = STILLGRID_VERSION;
    if (!arguments.transition.empty())
      arguments.options.transition = display::transition_named(arguments.transition);
    if (!arguments.group.empty())
      arguments.options.readers = publication::group_named(arguments.group);
    return safety::run_guarded(program_of(arguments));
  });
}

}  // namespace
}  // namespace stillgrid::haptic_server

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::haptic_server::program_main(argc, argv);
}
