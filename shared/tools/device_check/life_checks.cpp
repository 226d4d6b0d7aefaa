#include <array>
#include <cfenv>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <thread>

#include "shared/realtime/process_state.hpp"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"

namespace stillgrid::device_check {
namespace {

constexpr std::size_t kTicks = 20;

void live(CheckedDevice& device) {
  device.activate();
  read_ticks(device, kTicks);
  device.deactivate();
}

Outcome check_order(const Subject& subject) {
  CheckedDevice device(subject);
  const stillgrid_device_descriptor descriptor = device.describe();
  live(device);
  device.close();
  const std::string name(descriptor.name, ::strnlen(descriptor.name, STILLGRID_DEVICE_NAME_SIZE));
  return {Verdict::kPass, "device '" + name + "'", {}};
}

Outcome check_again(const Subject& subject) {
  CheckedDevice device(subject);
  for (int round = 0; round < 2; ++round) {
    if (round > 0) device.open(subject);
    for (int life = 0; life < 3; ++life) live(device);
    device.close();
  }
  return {};
}

std::size_t entries(const char* folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

struct Holdings {
  std::size_t threads = entries("/proc/self/task");
  std::size_t files = entries("/proc/self/fd");
};

Outcome check_leftovers(const Subject& subject) {
  const Holdings before;
  {
    CheckedDevice device(subject);
    live(device);
    device.close();
  }
  Holdings after;
  for (int n = 0; n < 100 && after.threads > before.threads; ++n) {  // a thread may be ending
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    after = Holdings();
  }
  std::string left;
  if (after.threads > before.threads)
    left = std::to_string(after.threads - before.threads) + " threads";
  if (after.files > before.files)
    left +=
        (left.empty() ? "" : " and ") + std::to_string(after.files - before.files) + " open files";
  if (left.empty()) return {};
  return {Verdict::kWarn, left + " more after close() than before the library was loaded", {}};
}

/// A thread's view of what no driver may change.
struct Surroundings {
  realtime::ProcessState process = realtime::process_state();
  int rounding = std::fegetround();
};

void require_same(const Surroundings& before, const Surroundings& after, const char* when) {
  for (std::size_t i = 0; i < realtime::kProcessParts.size(); ++i)
    if (after.process.parts[i] != before.process.parts[i])
      broken(std::string(realtime::kProcessParts[i]) + " changes " + when + ": '" +
             before.process.parts[i] + "', then '" + after.process.parts[i] + "'");
  if (after.rounding != before.rounding) broken("the rounding mode changes " + std::string(when));
}

Outcome check_surroundings(const Subject& subject) {
  const Surroundings before;
  CheckedDevice device(subject);
  device.activate();
  std::optional<Surroundings> first;
  run_ticks(kTicks, [&](std::uint64_t now_ns) {
    if (!first) first.emplace();
    stillgrid_device_state state{};
    const std::int32_t code = device.read(now_ns, state);
    device.require(code, "read()");
    if (code != STILLGRID_DEVICE_END) device.require(device.write(now_ns, {}), "write()");
    require_same(*first, Surroundings(), "in read() or write()");
    return code != STILLGRID_DEVICE_END;
  });
  device.deactivate();
  device.close();
  require_same(before, Surroundings(), "in the calls of the main thread");
  return {};
}

Outcome check_exit(const Subject& subject) {
  CheckedDevice device(subject);
  live(device);
  device.close();
  note_step("the end of the program, after close()");
  return {};
}

constexpr std::array kChecks = {
    Check{"life.order",
          "lives: enumerate, open, configure, describe, activate, read, write, "
          "deactivate, close",
          "negotiate.table", check_order},
    Check{"life.again", "can be activated again, and opened again after close", "life.order",
          check_again},
    Check{"life.leftovers", "leaves no thread and no open file behind after close", "life.order",
          check_leftovers},
    Check{"life.surroundings",
          "leaves signal mask, umask, folder, scheduling and rounding mode as they were",
          "life.order", check_surroundings},
    Check{"life.exit", "lets the program end", "life.order", check_exit, CheckProcess::kExits},
};

}  // namespace

std::span<const Check> life_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
