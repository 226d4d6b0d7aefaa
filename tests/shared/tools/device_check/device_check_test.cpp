#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/haptic_server/devices/recording_file.hpp"

// Runs the program, as its users do, on drivers that each break one rule.
namespace {

struct Run {
  std::string output;
  int status = -1;
};

Run run_program(const std::string& command) {
  Run run;
  std::FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return run;
  std::array<char, 4096> part{};
  for (std::size_t n = 0; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;)
    run.output.append(part.data(), n);
  const int status = ::pclose(pipe);
  run.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return run;
}

const std::string kProgram = STILLGRID_BINARY_DIR "/bin/device_check ";
const std::string kDrivers = STILLGRID_HOSTILE_DIR "/";
const std::string kShort = " --seconds 0.1 --timeout 3 --any-force";

Run check(const std::string& driver, const std::string& fault, const std::string& options) {
  return run_program("STILLGRID_HOSTILE_FAULT=" + fault + " " + kProgram + kDrivers + driver +
                     ".so " + options);
}

/// The names of the checks that ended like that.
std::set<std::string> names_of(const std::string& output, const std::string& verdict) {
  std::set<std::string> names;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(verdict + " ")) names.insert(line.substr(5, line.find(' ', 5) - 5));
  return names;
}

/// All that was complained of, but for calls that the machine made late.
std::set<std::string> complaints_of(const std::string& output) {
  std::set<std::string> names = names_of(output, "WARN");
  names.erase("timing.calls");
  names.merge(names_of(output, "FAIL"));
  return names;
}

bool has_guard() {
  return std::filesystem::exists(STILLGRID_BINARY_DIR "/lib/stillgrid/librealtime_guard.so");
}

struct Fault {
  const char* name;
  const char* check;  // the only one that may find it
  const char* why;    // what the line below it tells, in part
  int status = 3;
  const char* driver = "hostile";
};

constexpr Fault kFaults[] = {
    {"none", "library.exports", "hostile_helper", 3, "two_symbols"},
    {"none", "library.loads", "does not export stillgrid_device_negotiate", 3, "nameless"},
    {"none", "library.loads", "stillgrid_nowhere", 3, "undefined"},
    {"refuses_all", "negotiate.table", "E_VERSION"},
    {"wrong_version", "negotiate.table", "a table of version 7, expected 2"},
    {"no_stop", "negotiate.table", "leaves functions out"},
    {"takes_any_version", "negotiate.versions", "a host of version 0, expected E_VERSION"},
    {"null_host", "negotiate.nulls", "dies of SIGABRT in negotiate() of a null host"},
    {"table_overrun", "negotiate.sizes", "behind which nothing may be touched"},
    {"table_resized", "negotiate.sizes", "changes struct_size of the table"},
    {"host_overread", "negotiate.sizes", "a host info of 16"},
    {"enumerate_fails", "life.order", "enumerate() answers E_IO (-5)"},
    {"open_throws", "life.order", "an exception leaves open(): no luck"},
    {"activate_hangs", "life.order", "does not return within 3.1 s from activate()"},
    {"read_throws", "life.order", "an exception leaves read(): read"},
    {"read_hangs", "life.order", "does not return within 3.1 s from read()"},
    {"read_crashes", "life.order", " in read()"},
    {"write_throws", "life.order", "an exception leaves write()"},
    {"leave_throws", "life.order", "an exception leaves deactivate(): deactivate"},
    {"leave_fails", "life.order", "deactivate() answers E_IO (-5): it did not work"},
    {"close_crash", "life.order", "dies of SIGABRT in close()"},
    {"activates_once", "life.again", "activate() answers E_IO"},
    {"gone", "life.again", "no device is present"},
    {"opens_once", "life.again", "open() answers E_IO"},
    {"thread_left", "life.leftovers", "1 threads more", 0},
    {"file_left", "life.leftovers", "1 open files more", 0},
    {"opens_umask", "life.surroundings", "the umask changes in the calls of the main thread"},
    {"leaves_folder", "life.surroundings", "the working folder changes in the calls"},
    {"rounds_up", "life.surroundings", "the rounding mode changes in read() or write()"},
    {"masks_signals", "life.surroundings", "the signal mask changes in read() or write()"},
    {"exit_crash", "life.exit", "dies of SIGABRT in the end of the program"},
    {"exit_hang", "life.exit", "does not return within 3.1 s from the end of the program"},
    {"reads_early", "order.before_activate", "read() before activate() answers OK"},
    {"activates_twice", "order.while_active", "activate() while active answers OK"},
    {"configure_active", "order.while_active", "configure() while active answers OK"},
    {"reads_late", "order.after_deactivate", "read() after deactivate() answers OK"},
    {"writes_late", "order.after_deactivate", "write() after deactivate() answers OK"},
    {"leaves_early", "order.before_activate", "deactivate() before activate() answers OK"},
    {"leaves_twice", "order.after_deactivate", "deactivate() after deactivate() answers OK"},
    {"close_active", "order.close_active", "dies of SIGABRT in close()"},
    {"null_device", "arguments.no_device", "dies of SIGABRT in configure() of no device"},
    {"null_key", "arguments.nulls", "dies of SIGABRT in configure() of a null key"},
    {"null_force", "arguments.nulls", " in write() of a null force"},
    {"any_index", "arguments.index", "open() of device 1 of 1 answers OK"},
    {"unknown_key", "arguments.options", "the unknown key 'no.such.key' answers OK"},
    {"unknown_key_throws", "arguments.options", "an exception leaves configure()"},
    {"descriptor_overrun", "arguments.sizes", "describe() with a struct of"},
    {"descriptor_resized", "arguments.sizes", "describe() changes struct_size"},
    {"state_overrun", "arguments.sizes", "read() with a struct of"},
    {"state_resized", "arguments.sizes", "read() changes struct_size"},
    {"speechless", "arguments.errors", "gives null"},
    {"talkative", "arguments.errors", "more than one line"},
    {"endless_name", "descriptor.name", "not zero-terminated"},
    {"nan_force", "descriptor.figures", "max_force_N is nan"},
    {"inside_out", "descriptor.figures", "from 0.2 to 0.1 m"},
    {"weak_for_a_moment", "descriptor.figures", "continuous_force_N is more than max_force_N"},
    {"freedom_of_ghosts", "descriptor.freedom", "degrees of freedom that do not exist"},
    {"many_axes", "descriptor.freedom", "more axes than a state"},
    {"no_gripper", "descriptor.freedom", "differ in whether there is a gripper"},
    {"drifting_rate", "descriptor.same", "rate_hz changes from 1000"},
    {"no_max_read", "descriptor.max_read", "max_read_ns is 0"},
    {"nothing_valid", "read.fields", "read 1: no position is marked valid"},
    {"nan_position", "read.fields", "read 15: the position is marked valid and holds nan"},
    {"long_quaternion", "read.fields", "the orientation's norm is 1.5"},
    {"long_axis", "read.fields", "read 1: an axis is 1.5, expected from -1 to 1"},
    {"nan_gripper", "read.fields", "the gripper's opening is marked valid and holds nan"},
    {"time_back", "read.time", "time_ns goes back by"},
    {"time_zero", "read.time", "ms old by their time_ns"},
    {"time_ahead", "read.time", "in the future of CLOCK_MONOTONIC"},
    {"sequence_stays", "read.sequence", "sequence stays 1 for 100 reads"},
    {"sequence_back", "read.sequence", "sequence goes back from 14 to 13"},
    {"sequence_lies", "read.sequence", "another position with the same sequence"},
    {"millimetres", "read.believed", "read 1: haptic_server would not believe it: too_far"},
    {"slips", "read.believed", "read 15: haptic_server would not believe it: leap"},
    {"leaves_workspace", "read.workspace",
     "along axis 0, workspace from -0.1 to -0.01 m: there is no force", 0},
    {"poisoned_by_force", "write.extremes", "the position is"},
    {"huge_force", "write.extremes", "dies of SIGABRT in write()"},
    {"stop_throws", "stop.any_thread", "an exception leaves emergency_stop(): stop"},
    {"stop_of_one_thread", "stop.any_thread", "dies of SIGABRT in"},
    {"stop_stays", "stop.any_thread", "activate() answers E_IO"},
    {"knows_all", "extensions.unknown", "of 'no.such.extension/1' is not null"},
    {"endless_serial", "extensions.identity", "serial is not zero-terminated"},
    {"identity_overrun", "extensions.identity", "identify() with a struct of"},
    {"identity_resized", "extensions.identity", "identify() changes struct_size"},
    {"logs_in_realtime", "extensions.host", "the real-time thread logs a line"},
    {"needs_log", "extensions.host", "dies of SIGABRT in negotiate()"},
    {"no_ticks", "pace.ticks", "0 ticks in 0.5 s, 500 due"},
    {"ticks_seldom", "pace.ticks", "ticks in 0.5 s, 500 due", 0},
    {"ticks_twice", "pace.ticks", "more than one thread"},
    {"no_set_tick", "pace.ticks", "set_tick is null"},
    {"ticks_on", "pace.end", "come after one that was the last"},
    {"late_tick", "pace.given", "set_tick() while active answers OK"},
    {"keeps_tick", "pace.given", "a tick comes that was refused or taken back"},
    {"endless_list", "services.list", "the list has no end"},
    {"same_options", "services.list", "two devices of the list are opened by the same options"},
    {"options_of_no_use", "services.list", "options 'serial' cannot be given to --device"},
    {"endless_serial_listed", "services.list", "serial is not zero-terminated"},
    {"listing_overrun", "services.list", "list() with a struct of"},
    {"listing_resized", "services.list", "list() changes struct_size"},
    {"any_order", "services.command", "command() of an unknown key answers OK"},
    {"orders_early", "services.command", "command() before activate()"},
    {"null_order", "services.command", "dies of SIGABRT in command()"},
    {"grips_late", "services.gripper", "write_gripper() before activate() is not refused"},
    {"grips_nan", "services.gripper", "of a force that is no number is not refused"},
    {"slow", "timing.calls", "one call of a hundred took longer than the declared 300000 ns"},
    {"unlucky_order", "fuzz.order", "emergency_stop(), deactivate(), configure(unknown key)"},
};

/// Of these the guard tells; where there is none nobody does.
constexpr Fault kBlockingFaults[] = {
    {"allocates", "realtime.memory", "malloc 100 times, first from hostile.so+0x"},
    {"declared_allocation", "realtime.memory", "malloc 100 times"},
    {"throws_inside", "realtime.memory", "malloc 200 times"},
    {"locks", "realtime.waits", "pthread_mutex_lock 100 times, first from hostile.so+0x"},
    {"system_call", "realtime.system_calls", "write 100 times, first from hostile.so+0x"},
};

/// What is wrong with how the fault was found, or nothing.
std::string complaint(const Fault& fault) {
  const Run run = check(fault.driver, fault.name, kShort);
  std::set<std::string> found = complaints_of(run.output);
  // Beside a dozen others calls are late for no fault of the driver's.
  if (fault.check != std::string("timing.calls")) found.erase("timing.calls");
  const bool is_found = found == std::set<std::string>{fault.check};
  const bool is_told = run.output.find(fault.why) != std::string::npos;
  if (is_found && is_told && run.status == fault.status) return {};
  return std::string(fault.driver) + " with " + fault.name + ": expected " + fault.check + ", '" +
         fault.why + "', status " + std::to_string(fault.status) + "; status " +
         std::to_string(run.status) + " and\n" + run.output + "\n";
}

/// Most of what the checks do is wait, for ticks or for what hangs: many at once.
void at_once(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> workers;
  for (int n = 0; n < 12; ++n)
    workers.emplace_back([&] {
      for (std::size_t at = 0; (at = next++) < count;) work(at);
    });
}

template <class Faults>
std::string complaints(const Faults& faults) {
  std::vector<std::string> all(std::size(faults));
  at_once(all.size(), [&](std::size_t n) { all[n] = complaint(faults[n]); });
  std::string joined;
  // Beside a dozen others a tick may be late: once more alone.
  for (std::size_t n = 0; n < all.size(); ++n)
    if (!all[n].empty()) joined += complaint(faults[n]);
  return joined;
}

TEST_CASE("Each fault is found by the check of its rule and by no other", "[device_check]") {
  CHECK(complaints(kFaults) == "");
}

TEST_CASE("What may block the real-time thread is found by the guard", "[device_check]") {
  if (!has_guard()) {
    WARN("skipped: a sanitizer or this processor keeps the guard from being built");
    return;
  }
  CHECK(complaints(kBlockingFaults) == "");
}

TEST_CASE("A driver without faults passes every check", "[device_check]") {
  const Run run = check("hostile", "none", kShort);
  INFO(run.output);
  CHECK(complaints_of(run.output).empty());
  CHECK(names_of(run.output, "SKIP").size() == (has_guard() ? 0 : 3));
  CHECK(run.status == 0);
}

TEST_CASE("Declared system calls are told and are no fault", "[device_check]") {
  const Run run = check("hostile", "declared_system_call", kShort + " --only 'realtime.*'");
  INFO(run.output);
  CHECK(run.status == 0);
  if (has_guard()) CHECK(run.output.find(": declared: write 100 times") != std::string::npos);
}

TEST_CASE("The devices that ship pass every check", "[device_check]") {
  const stillgrid::devices::RecordingFile file(
      "t_s,x_m,y_m,z_m\n0,0,0,0.01\n0.05,0.01,0,0\n0.1,0,0,0.01\n");
  const std::string replay = "replay:file=" + file.path();
  const std::array<std::string, 5> devices = {
      "phantom", "mouse:session=checked",
      "phantom:profile=premium15,hand=none,path=circle,pivot_x_m=0,pivot_y_m=0,pivot_z_m=-0.1",
      replay, replay + ",loop=1"};
  std::array<Run, 5> runs;
  at_once(devices.size(),
          [&](std::size_t n) { runs.at(n) = run_program(kProgram + devices.at(n) + kShort); });
  for (const Run& run : runs) {
    INFO(run.output);
    CHECK(complaints_of(run.output).empty());
    CHECK(run.status == 0);
  }
}

TEST_CASE("Forces are written only if they may be", "[device_check]") {
  const Run run = check("hostile", "huge_force", "--seconds 0.1 --only write.extremes 'fuzz.*'");
  INFO(run.output);
  CHECK(run.status == 0);
  CHECK(names_of(run.output, "SKIP") == std::set<std::string>{"write.extremes"});
}

TEST_CASE("A seed gives the same random calls again", "[device_check]") {
  const auto sequence = [](const std::string& seed) {
    return check("hostile", "unlucky_order", kShort + " --only fuzz.order --seed " + seed).output;
  };
  CHECK(sequence("7") == sequence("7"));
  CHECK(sequence("7") != sequence("8"));
}

TEST_CASE("Without a device the library is checked, and the status says so", "[device_check]") {
  for (const std::string& fault : {std::string("nothing_there"), std::string("unplugged")}) {
    const Run run = check("hostile", fault, kShort);
    INFO(run.output);
    CHECK(run.status == 2);
    CHECK(run.output.find("SKIP life.order             no device") != std::string::npos);
    CHECK(names_of(run.output, "PASS").contains("negotiate.sizes"));
    CHECK(complaints_of(run.output).empty());
  }
}

TEST_CASE("Bad input is one line", "[device_check]") {
  const auto refused = [](const std::string& arguments, const std::string& expected) {
    const Run run = run_program(kProgram + arguments);
    INFO(arguments << "\n" << run.output);
    CHECK(run.status == 1);
    CHECK(run.output.starts_with("device_check: "));
    CHECK(std::count(run.output.begin(), run.output.end(), '\n') == 1);
    CHECK(run.output.find(expected) != std::string::npos);
  };
  refused("", "expected DEVICE");
  refused("/nowhere/none.so", "there is no such file");
  refused("phantom --only read.everything", "read.everything");
  refused("phantom --seconds nan", "nan");
  refused("phantom --only life.order --json /nowhere/report.json", "/nowhere/report.json");
}

TEST_CASE("Options that the driver refuses are bad input", "[device_check]") {
  const Run run = run_program(kProgram + "phantom:hand=heavy");
  CHECK(run.status == 1);
  CHECK(run.output.find("expected none, light or measured") != std::string::npos);
}

TEST_CASE("The report holds what was printed", "[device_check]") {
  const stillgrid::devices::RecordingFile file("");
  const Run run = check("hostile", "time_ahead", "--only 'read.*' --json " + file.path());
  std::ifstream stream(file.path());
  const std::string json((std::istreambuf_iterator<char>(stream)), {});
  CHECK(run.output.find("5 checks: 2 passed, 1 failed, 0 warnings, 2 skipped") !=
        std::string::npos);
  CHECK(json.find("\"failed\": 1") != std::string::npos);
  CHECK(json.find("\"name\": \"read.time\"") != std::string::npos);
}

TEST_CASE("One check may be run in the program itself", "[device_check]") {
  CHECK(check("hostile", "none", "--only read.time --in-process").status == 0);
  CHECK(check("hostile", "time_ahead", "--only read.time --in-process").status == 3);
}

}  // namespace
