#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "shared/realtime/realtime_guard.hpp"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"

namespace stillgrid::device_check {
namespace {

enum class Kind { kMemory, kWait, kSystemCall };

/// What a call that the guard names is done for. The system calls that allocators and locks make
/// belong to those.
Kind kind_of(std::string_view call) {
  constexpr std::array<std::string_view, 13> kMemory = {
      "malloc",        "calloc",         "realloc", "free",   "memalign",
      "aligned_alloc", "posix_memalign", "mmap",    "munmap", "mremap",
      "madvise",       "mprotect",       "brk"};
  if (std::find(kMemory.begin(), kMemory.end(), call) != kMemory.end()) return Kind::kMemory;
  const bool is_wait = call.starts_with("pthread_") || call.starts_with("sem_") || call == "futex";
  return is_wait ? Kind::kWait : Kind::kSystemCall;
}

/// The calls of that kind in 100 ticks, or nothing: "malloc 100 times, first from x.so+0x1441".
std::string calls_of(Kind kind, CheckedDevice& device) {
  device.activate();
  read_ticks(device, 100);
  device.deactivate();
  std::string calls;
  for (const realtime::RealtimeViolation& violation : realtime::realtime_violations())
    if (kind_of(violation.call) == kind)
      calls += (calls.empty() ? "" : "; ") + violation.call + " " +
               std::to_string(violation.count) + " times, first from " + violation.first_caller +
               " at tick " + std::to_string(violation.first_tick);
  return calls;
}

Outcome check_kind(Kind kind, const Subject& subject) {
  CheckedDevice device(subject);
  const std::string calls = calls_of(kind, device);
  if (!calls.empty()) broken(calls);
  return {};
}

Outcome check_memory(const Subject& subject) {
  return check_kind(Kind::kMemory, subject);
}

Outcome check_waits(const Subject& subject) {
  return check_kind(Kind::kWait, subject);
}

Outcome check_system_calls(const Subject& subject) {
  CheckedDevice device(subject);
  const bool may = (device.describe().flags & STILLGRID_DEVICE_USES_SYSCALLS) != 0;
  const std::string calls = calls_of(Kind::kSystemCall, device);
  if (!calls.empty() && !may) broken(calls + " (or declare STILLGRID_DEVICE_USES_SYSCALLS)");
  if (calls.empty() && may)
    return {Verdict::kPass, "it declares some, and made none in 100 ticks", {}};
  return {Verdict::kPass, calls.empty() ? "" : "declared: " + calls, {}};
}

constexpr std::array kChecks = {
    Check{"realtime.memory", "allocates and frees nothing in read and write", "life.order",
          check_memory, CheckProcess::kGuard},
    Check{"realtime.waits", "takes no lock and starts no thread in read and write", "life.order",
          check_waits, CheckProcess::kGuard},
    Check{"realtime.system_calls",
          "makes no system call that it does not declare, in read and "
          "write",
          "life.order", check_system_calls, CheckProcess::kGuard},
};

}  // namespace

std::span<const Check> realtime_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
