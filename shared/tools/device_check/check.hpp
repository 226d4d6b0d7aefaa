#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "haptic_server/device/device_spec.hpp"
#include "shared/tools/device_check/verdict.hpp"

namespace stillgrid::device_check {

/// Part of one sequence of random calls: those that are kept when a failure is made shorter.
struct FuzzPart {
  std::uint64_t sequence = 0;
  std::vector<std::size_t> calls;  // ascending
};

/// The driver that is checked, and how.
struct Subject {
  std::filesystem::path library;
  std::vector<device::DeviceOption> options;
  std::uint32_t index = 0;  // of the device, among those that enumerate() counts
  std::uint64_t seed = 1;
  double seconds = 5.0;    // of timing, and at most of random calls
  bool any_force = false;  // forces other than zero may be written
  std::optional<FuzzPart> fuzz_part;
};

/// What a check needs of the process that it runs in.
enum class CheckProcess {
  kPlain,  // ends as soon as the outcome is known
  kGuard,  // librealtime_guard.so watches
  kExits,  // ends as programs do, with the driver's destructors
};

/// One rule of proto/device_plugin.h and how to see whether a driver keeps it.
struct Check {
  const char* name;   // "group.rule"
  const char* rule;   // what a driver does that keeps it, in one line
  const char* needs;  // names, or "group.*", separated by blanks: without them this says nothing
  Outcome (*run)(const Subject&);  // may throw CheckEnded
  CheckProcess process = CheckProcess::kPlain;
};

/// The checks of each group, in the order in which they are run.
[[nodiscard]] std::span<const Check> library_checks();
[[nodiscard]] std::span<const Check> negotiate_checks();
[[nodiscard]] std::span<const Check> life_checks();
[[nodiscard]] std::span<const Check> order_checks();
[[nodiscard]] std::span<const Check> argument_checks();
[[nodiscard]] std::span<const Check> descriptor_checks();
[[nodiscard]] std::span<const Check> read_checks();
[[nodiscard]] std::span<const Check> force_checks();
[[nodiscard]] std::span<const Check> extension_checks();
[[nodiscard]] std::span<const Check> pace_checks();
[[nodiscard]] std::span<const Check> service_checks();
[[nodiscard]] std::span<const Check> realtime_checks();
[[nodiscard]] std::span<const Check> timing_checks();
[[nodiscard]] std::span<const Check> fuzz_checks();

/// All of them.
[[nodiscard]] std::vector<Check> all_checks();

/// Whether "group.*" or a full name names the check.
[[nodiscard]] bool names(std::string_view pattern, std::string_view check) noexcept;

}  // namespace stillgrid::device_check
