#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/files/json_file.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/realtime_guard.hpp"
#include "shared/tools/device_check/check_process.hpp"
#include "shared/tools/device_check/check_record.hpp"
#include "shared/tools/device_check/fuzz.hpp"
#include "shared/tools/device_check/results.hpp"

namespace stillgrid::device_check {
namespace {

struct Arguments {
  std::string device;
  std::vector<std::string> only;
  bool list = false, in_process = false;
  double timeout_s = 10.0;
  std::filesystem::path json;
  Subject subject;
  // Of the process of one check:
  std::string run;
  int record_file = -1;
  std::string fuzz_part;
};

constexpr const char* kDescription =
    "Checks whether a device driver keeps the rules of the plugin interface, each in a process of "
    "its own.\n"
    "\n"
    "  device_check ./libknob.so:port=3\n"
    "  device_check phantom --only 'read.*' timing.calls --seconds 60\n"
    "\n"
    "Activates the device, and writes no force but zero unless --any-force. Exit status: 0 no rule "
    "broken;\n"
    "1 bad input; 2 no device is present, so that only the library was checked; 3 a rule is "
    "broken.\n";

void add_options(CLI::App& app, Arguments& arguments) {
  Subject& subject = arguments.subject;
  app.add_option("DEVICE", arguments.device, "PLUGIN[:key=value,...], as for haptic_server");
  app.add_flag("--list", arguments.list, "Print the checks and their rules, and end");
  app.add_option("--only", arguments.only, "Run these checks alone: names, or 'group.*'")
      ->type_name("NAME");
  app.add_option("--seconds", subject.seconds,
                 "How long calls are timed, and at most random ones made, s; default 5")
      ->check(command_line::number_in(0.01, 1e6));
  app.add_option("--seed", subject.seed, "Of the random calls; default 1")
      ->check(command_line::integer_in(0, 999'999'999'999'999));
  app.add_option("--timeout", arguments.timeout_s,
                 "What takes this much longer has hung, s; default 10")
      ->check(command_line::number_in(0.1, 1e6));
  app.add_flag("--any-force", subject.any_force,
               "Write forces of any size too, for less than a millisecond each: hands off a device "
               "with motors");
  app.add_option("--json", arguments.json, "Write the results");
  app.add_flag("--in-process", arguments.in_process,
               "Run the one check of --only in this process, for a debugger");
  app.add_option("--run", arguments.run)->group("");
  app.add_option(kRecordOption, arguments.record_file)->group("");
  app.add_option("--fuzz-part", arguments.fuzz_part)->group("");
}

/// Those that --only names, or all.
std::vector<Check> selected_checks(const std::vector<std::string>& only) {
  std::vector<Check> all = all_checks();
  if (only.empty()) return all;
  for (const std::string& name : only)
    if (std::none_of(all.begin(), all.end(), [&](const Check& c) { return names(name, c.name); }))
      throw std::runtime_error("--only: value '" + name + "': expected a name that --list prints");
  std::vector<Check> selected;
  for (const Check& check : all)
    if (std::any_of(only.begin(), only.end(),
                    [&](const std::string& name) { return names(name, check.name); }))
      selected.push_back(check);
  return selected;
}

/// "7:0,3,12": of sequence 7 these calls. Written by this program alone.
std::string text_of_part(const FuzzPart& part) {
  std::string text = std::to_string(part.sequence);
  for (const std::size_t call : part.calls) text += " " + std::to_string(call);
  return text;
}

FuzzPart parse_part(const std::string& text) {
  std::istringstream numbers(text);
  FuzzPart part;
  numbers >> part.sequence;
  for (std::size_t call = 0; numbers >> call;) part.calls.push_back(call);
  return part;
}

/// The process of one check. Returns its exit status if it ends as programs do.
int run_child(const Arguments& arguments, char** argv) {
  if (arguments.record_file >= 0) share_record(arguments.record_file);
  const Check check = selected_checks({arguments.run}).front();
  if (check.process == CheckProcess::kGuard) {
    try {
      realtime::require_realtime_guard(argv);
    } catch (const std::exception& error) {
      settle({Verdict::kSkip, std::string("not without the guard: ") + error.what(), {}});
    }
  }
  if (this_record().verdict == Verdict::kNone && run_here(check, arguments.subject) &&
      arguments.record_file >= 0)
    return realtime::kDone;
  const CheckRecord& record = this_record();
  if (arguments.record_file < 0) {
    const Outcome outcome{record.verdict, record.line.data(), record.details.data()};
    std::fputs(text_of({check, outcome}).c_str(), stdout);
    return outcome.verdict == Verdict::kFail ? realtime::kDeviceFault : realtime::kDone;
  }
  std::fflush(nullptr);
  ::_exit(realtime::kDone);
}

/// Adds the shortest sequence of random calls that still fails.
void shrink(ProcessOutcome& outcome, const std::vector<std::string>& command,
            const Arguments& arguments) {
  const std::uint64_t seed = arguments.subject.seed;
  const std::uint64_t sequence = outcome.fuzz_sequence;
  std::vector<std::size_t> kept;
  if (!outcome.has_hung)
    kept = shrink_calls([&](const std::vector<std::size_t>& calls) {
      std::vector<std::string> part = command;
      part.insert(part.end(), {"--fuzz-part", text_of_part({sequence, calls})});
      return run_in_process(part, arguments.timeout_s).verdict == Verdict::kFail;
    });
  const bool is_shrunk = !kept.empty();
  if (!is_shrunk)
    for (std::size_t call = 0; call < kFuzzCalls; ++call) kept.push_back(call);
  outcome.details = "sequence " + std::to_string(sequence) + " of seed " + std::to_string(seed) +
                    (is_shrunk ? ", as short as it still fails: " : ": ") +
                    fuzz_text(seed, sequence, kept) + "\n" + outcome.details;
}

/// The first that the check needs and that was not passed, or nothing.
std::string missing_need(const Check& check, const std::vector<CheckResult>& results) {
  std::istringstream needs(check.needs);
  for (std::string need; needs >> need;)
    for (const CheckResult& result : results)
      if (names(need, result.check.name) && result.outcome.verdict != Verdict::kPass &&
          result.outcome.verdict != Verdict::kWarn)
        return result.check.name;
  return {};
}

/// A device that has lived once may neither be gone nor refuse the options that it took.
void judge_again(Outcome& outcome, const std::vector<CheckResult>& results) {
  const bool is_excuse =
      outcome.verdict == Verdict::kAbsent || outcome.verdict == Verdict::kRefused;
  const bool has_lived = std::any_of(results.begin(), results.end(), [](const CheckResult& result) {
    return names("life.order", result.check.name) && result.outcome.verdict == Verdict::kPass;
  });
  if (is_excuse && has_lived) outcome.verdict = Verdict::kFail;
}

CheckResult result_of(const Check& check, const std::vector<CheckResult>& results,
                      const Arguments& arguments, char** argv) {
  if (const std::string need = missing_need(check, results); !need.empty())
    return {check, {Verdict::kSkip, "needs " + need, {}}, 0.0};
  std::vector<std::string> command;
  for (char** argument = argv; *argument != nullptr; ++argument) command.emplace_back(*argument);
  command.insert(command.end(), {"--run", check.name});
  const std::uint64_t start_ns = realtime::monotonic_ns();
  ProcessOutcome outcome = run_in_process(command, arguments.timeout_s + arguments.subject.seconds);
  const double time_s = static_cast<double>(realtime::monotonic_ns() - start_ns) * 1e-9;
  judge_again(outcome, results);
  if (outcome.verdict == Verdict::kFail && names("fuzz.*", check.name))
    shrink(outcome, command, arguments);
  return {check, outcome, time_s};
}

/// Runs and prints all; returns the exit status.
int check_driver(const Arguments& arguments, char** argv) {
  if (!arguments.json.empty()) files::require_writable(arguments.json);
  std::vector<CheckResult> results;
  bool is_absent = false;
  for (const Check& check : selected_checks(arguments.only)) {
    results.push_back(result_of(check, results, arguments, argv));
    const Outcome& outcome = results.back().outcome;
    if (outcome.verdict == Verdict::kRefused)
      throw std::runtime_error("device '" + arguments.device + "': " + outcome.line);
    is_absent = is_absent || outcome.verdict == Verdict::kAbsent;
    std::fputs(text_of(results.back()).c_str(), stdout);
    std::fflush(stdout);
  }
  std::printf("%s\n", summary_of(results).c_str());
  if (!arguments.json.empty())
    files::write_json(arguments.json, json_of(results, arguments.subject));
  if (count_of(results, "FAIL") > 0) return realtime::kDeviceFault;
  return is_absent ? realtime::kCouldNotStart : realtime::kDone;
}

int list_checks() {
  for (const Check& check : all_checks()) std::printf("%-22s %s\n", check.name, check.rule);
  return realtime::kDone;
}

int run(Arguments& arguments, char** argv) {
  if (arguments.list) return list_checks();
  if (arguments.device.empty()) throw std::runtime_error("expected DEVICE: see --help");
  const device::DeviceSpec spec = device::parse_device_spec(arguments.device);
  arguments.subject.library = device::find_device_plugin(spec.plugin);
  arguments.subject.options = spec.options;
  arguments.subject.index = spec.index;
  if (!arguments.fuzz_part.empty()) arguments.subject.fuzz_part = parse_part(arguments.fuzz_part);
  if (arguments.in_process) {
    const std::vector<Check> checks = selected_checks(arguments.only);
    if (checks.size() != 1) throw std::runtime_error("--in-process: expected one check in --only");
    arguments.run = checks.front().name;
  }
  return arguments.run.empty() ? check_driver(arguments, argv) : run_child(arguments, argv);
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "device_check");
  Arguments arguments;
  add_options(app, arguments);
  command_line::add_version(app, {command_line::device_interface()});
  return command_line::run_program(app, argc, argv, [&] { return run(arguments, argv); });
}

}  // namespace
}  // namespace stillgrid::device_check

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::device_check::program_main(argc, argv);
}
