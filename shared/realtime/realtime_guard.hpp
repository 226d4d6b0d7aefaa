#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace stillgrid::realtime {

struct GuardTable;  // shared/realtime/guard/guard_table.hpp

/// A call that was made inside a RealtimeSection and may block, wait or take unbounded time.
struct RealtimeViolation {
  std::string call;  // "malloc", "pthread_mutex_lock", "write"
  std::uint64_t count = 0;
  std::uint64_t first_tick = 0;
  std::string first_caller;  // module and offset: "replay.so+0x12ab"
};

/// Whether librealtime_guard.so watches this process: docs/realtime.md.
[[nodiscard]] bool realtime_guard_is_loaded() noexcept;

/// Returns if the guard watches this process; otherwise runs the program anew with it.
///
/// arguments: main()'s, ending with a null. Throws std::runtime_error, one line, if there is no
/// guard beside this program or it cannot be loaded. Before any thread starts.
void require_realtime_guard(char** arguments);

/// What happened in all sections so far, in order of their first ticks. Not inside a section.
[[nodiscard]] std::vector<RealtimeViolation> realtime_violations();

/// From its construction to its destruction, the calling thread's calls that may block are counted,
/// if the guard watches this process; does nothing otherwise. Not nested.
///
/// The guard's filter of system calls stays with the thread after the section: its calls are made,
/// uncounted, but more slowly.
class RealtimeSection {
 public:
  /// Throws std::system_error if the kernel refuses the filter.
  RealtimeSection();
  ~RealtimeSection();
  RealtimeSection(const RealtimeSection&) = delete;
  RealtimeSection& operator=(const RealtimeSection&) = delete;
  RealtimeSection(RealtimeSection&&) = delete;
  RealtimeSection& operator=(RealtimeSection&&) = delete;

  /// Names the tick that begins, for the report. Realtime: yes.
  void begin_tick(std::uint64_t tick) noexcept;

 private:
  const GuardTable* guard_;  // null: no guard watches
};

}  // namespace stillgrid::realtime
