#pragma once

#include <cstdint>

namespace stillgrid::realtime {

/// A call that real-time sections made, as librealtime_guard.so tells it.
struct GuardEntry {
  const char* call;  // of the interposed function or the system call
  std::uint64_t count;
  std::uint64_t first_tick;
  const char* first_caller;  // "replay.so+0x12ab"
};

/// What librealtime_guard.so does for shared/realtime/realtime_guard.hpp, which finds this table by
/// its name. Program and library are of one build.
struct GuardTable {
  /// Begins a section of the calling thread. 0, or the errno of what could not be had.
  int (*enter)();
  /// The number of the tick that begins. Realtime: yes.
  void (*begin_tick)(std::uint64_t tick);
  void (*leave)();
  /// Visits every call that happened, in no order. Not inside a section.
  void (*for_each)(void (*visit)(void* context, const GuardEntry& entry), void* context);
};

inline constexpr const char* kGuardTableName = "stillgrid_realtime_guard";

}  // namespace stillgrid::realtime
