#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

#include "haptic_server/device/release_device.hpp"
#include "haptic_server/safety/guardian.hpp"
#include "haptic_server/server.hpp"
#include "shared/command_line/number_in.hpp"
#include "shared/command_line/prepare_daemon.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/publication/segment.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/realtime_guard.hpp"
#include "shared/realtime/stop_signal.hpp"

namespace stillgrid {
namespace {

struct Arguments {
  HapticOptions options;
  std::string transition{name_of(options.transition)}, group;
  std::filesystem::path report;
  bool realtime_guard = false;
};

constexpr const char* kDescription =
    "Computes the force of a session's snapshots on a device, at 1 kHz.\n"
    "\n"
    "  haptic_server --session demo --device phantom:path=press,hand=light --record run.csv\n"
    "  haptic_server --session ci --lockstep --device replay:file=run.csv --record again.csv\n"
    "\n"
    "A device is the path of a plugin (.so) or the name of an installed one: phantom, replay, "
    "spacemouse.\n";

void add_options(CLI::App& app, Arguments& arguments) {
  HapticOptions& options = arguments.options;
  app.add_option("--session", options.session,
                 "Name that joins the two servers; USER/NAME: with USER's")
      ->required()
      ->transform(CLI::Validator(settle_session, ""));
  app.add_option("--device", options.device, "PLUGIN[:key=value,...]")->required();
  app.add_option("--rate", options.rate_hz, "Ticks a second, Hz; default 1000")
      ->check(number_in(10.0, 1e5));
  std::vector<std::string> names;
  std::string remarks;
  for (const TransitionLaw& law : transitions()) {
    names.emplace_back(law.name);
    remarks += "; " + names.back() + ": " + std::string(law.remark);
  }
  app.add_option("--transition", arguments.transition,
                 "How one snapshot passes to the next, default " + arguments.transition + remarks)
      ->check(CLI::IsMember(names));
  app.add_option("--record", options.record, "Record every tick (CSV)");
  app.add_option("--duration", options.duration_s,
                 "Time to run, s; default: until Ctrl-C or the end of a replay")
      ->check(number_in(1e-6, 1e8));
  app.add_flag("--lockstep", options.lockstep,
               "Virtual time, in agreement with sim_server --lockstep; repeatable to the bit");
  app.add_option("--report", arguments.report, "Write a report (JSON) at exit");
  app.add_option("--cpu", options.cpu, "Run the loop on this processor")
      ->check(integer_in(0, 8191));
  app.add_option("--group", arguments.group,
                 "Let this group of users read the session too; default: only its owner")
      ->check(group_complaint);
  app.add_option("--max-force", options.safety.max_force_N,
                 "Limit of the force, N; default and upper bound: the device's own")
      ->check(number_in(1e-6, 1e4));
  app.add_option("--max-slew", options.safety.max_slew_N_per_ms,
                 "Limit of the force's growth and turn, N/ms; default: a tenth of its limit in a "
                 "millisecond; its norm may fall at once")
      ->check(number_in(1e-9, 1e6));
  app.add_option("--max-stiffness", options.safety.max_stiffness_N_per_m,
                 "Limit of the stiffness of all contacts together, N/m; default: what the device "
                 "declares")
      ->check(number_in(1e-3, 1e9));
  app.add_option("--max-speed", options.safety.max_speed_m_s,
                 "Speed above which the force no longer drives the device, m/s; default: what the "
                 "device declares")
      ->check(number_in(1e-3, 1e3));
  app.add_option("--passivity-control", options.safety.passivity_mass_kg,
                 "Damp away the energy that the held force gives. KG: apparent mass of the device "
                 "with the hand, which the damper stops in no less than a tick; default: off")
      ->check(number_in(1e-4, 100.0))
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
int name_violations(const std::vector<RealtimeViolation>& violations) {
  for (const RealtimeViolation& violation : violations)
    spdlog::error("real-time violation: {}, {} times, first from {} at tick {}", violation.call,
                  violation.count, violation.first_caller, violation.first_tick);
  return violations.empty() ? kDone : kRealtimeViolation;
}

/// Runs the loop; the report is written however it ended.
int run(Arguments& arguments, GuardedState& guarded) {
  HapticReport report;
  int status = kDone, report_status = kDone;
  const auto finish_report = [&] {
    try {
      if (!arguments.report.empty() && report.ticks > 0) write_report(report, arguments.report);
    } catch (const std::exception& error) {
      report_status = fail(error, kBadInput);
    }
  };
  arguments.options.ended = [&] {
    if (report.lost_rows > 0)
      spdlog::warn("{} ticks are missing from the record", report.lost_rows);
    if (arguments.realtime_guard) report.realtime_violations = realtime_violations();
    finish_report();
  };
  // The loop stands still, in a driver's call or told to, and counts nothing.
  arguments.options.give_up = [&](const std::string& line) {
    std::fprintf(stderr, "haptic_server: %s\n", line.c_str());
    finish_report();
    guarded.end_status = kDeviceFault;
    std::_Exit(kDeviceFault);
  };
  if (!arguments.report.empty()) require_writable(arguments.report);
  try {
    run_haptics(arguments.options, report, guarded, stop_requested());
  } catch (const DeviceError& error) {
    status = fail(error, error.exit_status());
  } catch (const DeviceFault& error) {
    status = fail(error, kDeviceFault);
  } catch (const SegmentError& error) {
    status = fail(error, kCouldNotStart);
  }
  if (report.realtime_violations) {
    const int verdict = name_violations(*report.realtime_violations);
    if (status == kDone) status = verdict;
  }
  if (const int number = rare_stop_signal(); number != 0 && status == kDone) {
    spdlog::error("ended by signal {} ({})", number, ::strsignal(number));
    status = kSignalled + number;
  }
  return status == kDone ? report_status : status;
}

GuardedProgram program_of(Arguments& arguments) {
  const DeviceSpec spec = parse_device_spec(arguments.options.device);
  const DeviceLoop loop{.period_ns = to_ns(1.0 / arguments.options.rate_hz)};
  GuardedProgram program;
  program.subject = "device '" + spec.plugin + "'";
  program.work = [&arguments](GuardedState& guarded) {
    prepare_daemon("haptic_server");
    install_rare_stop_signals();
    try {
      return run(arguments, guarded);
    } catch (const std::exception& error) {
      return fail(error, kBadInput);
    }
  };
  for (const ReleaseWay way :
       {ReleaseWay::kEveryCall, ReleaseWay::kStopAlone, ReleaseWay::kWithoutStop})
    program.releases.push_back([spec, loop, way] { release_device(spec, loop, way); });
  return program;
}

}  // namespace
}  // namespace stillgrid

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  using namespace stillgrid;
  CLI::App app(kDescription, "haptic_server");
  Arguments arguments;
  add_options(app, arguments);
  add_version(app, {segment_interface(), device_interface()});
  return run_program(app, argc, argv, [&] {
    if (arguments.realtime_guard) require_realtime_guard(argv);
    arguments.options.transition = *transition_named(arguments.transition);
    if (!arguments.group.empty()) arguments.options.readers = group_named(arguments.group);
    return run_guarded(program_of(arguments));
  });
}
