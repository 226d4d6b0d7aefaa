#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

namespace stillgrid::realtime {

/// What a thread got of what a real-time thread needs (docs/realtime.md, "Rights").
struct RealtimeRights {
  enum class Way { kNone, kFifo, kRealtimeKit };
  Way way = Way::kNone;
  int priority = 0;  // 1 to 99; 0 without a way
  bool is_memory_locked = false;
  std::optional<int> missing_cpu;  // asked for, and not there for us
  std::string refusal;             // what RealtimeKit answered; empty where it was not asked
};

/// Makes the calling thread real-time: SCHED_FIFO at priority 80, memory locked, 256 KiB of its
/// stack there, pinned to cpu if given. Threads that it starts are not. What cannot be had is told,
/// and the thread runs on without it.
[[nodiscard]] RealtimeRights take_rights(std::optional<int> cpu);

/// Asks RealtimeKit, over the system's D-Bus, to schedule a thread of this process that has no way
/// yet: SCHED_RR at 20 or its own limit, whichever is less. Waits for it 1 s at most. Once it is
/// granted, a loop that runs for 100 ms without a rest goes on as any other thread (was_demoted()):
/// the kernel would kill the process at RealtimeKit's limit of 200 ms.
///
/// Does nothing where rights.way is not kNone. Thread: any, one at a time.
void ask_realtime_kit(RealtimeRights& rights, pid_t thread);

/// Whether the thread that RealtimeKit made real-time lost its priority since. Thread: any.
[[nodiscard]] bool was_demoted() noexcept;

/// "fifo", "rtkit" or "other", as in reports.
[[nodiscard]] const char* way_name(const RealtimeRights& rights) noexcept;

/// What is missing and who grants it, in one line after "running without "; empty: nothing is.
[[nodiscard]] std::string missing_line(const RealtimeRights& rights);

}  // namespace stillgrid::realtime
