#include "shared/realtime/guard/violations.hpp"

#include <dlfcn.h>
#include <unwind.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "shared/realtime/guard/guard_table.hpp"
#include "shared/realtime/guard/syscall_filter.hpp"

namespace stillgrid::realtime {
namespace {

struct Section {
  bool is_inside = false;
  bool is_filtered = false;  // the kernel takes no filter back: once a thread
  std::uint64_t tick = 0;
};

// initial-exec: the first touch of a thread may not allocate.
[[gnu::tls_model("initial-exec")]] thread_local constinit Section section;
constinit std::atomic<Violation*> newest = nullptr;

struct Frames {
  Violation& violation;
  std::size_t count = 0;
};

_Unwind_Reason_Code add_frame(_Unwind_Context* context, void* argument) {
  auto& frames = *static_cast<Frames*>(argument);
  int is_interrupted = 0;
  const std::uintptr_t address = _Unwind_GetIPInfo(context, &is_interrupted);
  if (address == 0 || frames.count == frames.violation.frames.size()) return _URC_END_OF_STACK;
  // A return address may already belong to the next line, or the next function.
  frames.violation.frames[frames.count++] = address - (is_interrupted != 0 ? 0 : 1);
  return _URC_NO_REASON;
}

void unwind_into(Violation& violation) noexcept {
  Frames frames{violation};
  _Unwind_Backtrace(add_frame, &frames);
}

/// What stands between the caller we look for and the call.
bool is_of_a_runtime(std::string_view module) {
  constexpr std::array kRuntimes = {"librealtime_guard.so", "libc.so", "libstdc++.so",
                                    "libgcc_s.so", "ld-linux"};
  return std::any_of(kRuntimes.begin(), kRuntimes.end(),
                     [&](std::string_view runtime) { return module.starts_with(runtime); });
}

using CallerText = std::array<char, 256>;

/// The innermost frame that is no runtime library's.
CallerText first_caller(const Violation& violation) {
  CallerText text{"unknown"};
  for (const std::uintptr_t address : violation.frames) {
    Dl_info found{};
    // NOLINTNEXTLINE(performance-no-int-to-ptr): an address in code
    if (address == 0 || ::dladdr(reinterpret_cast<void*>(address), &found) == 0) continue;
    const char* const slash = std::strrchr(found.dli_fname, '/');
    const char* const module = slash == nullptr ? found.dli_fname : slash + 1;
    if (is_of_a_runtime(module)) continue;
    std::snprintf(
        text.data(), text.size(), "%s+0x%zx", module,
        static_cast<std::size_t>(address - reinterpret_cast<std::uintptr_t>(found.dli_fbase)));
    break;
  }
  return text;
}

int enter() {
  static constinit Violation warmed_up;
  unwind_into(warmed_up);  // what the unwinder does only once, it does here
  if (!section.is_filtered) {
    if (const int code = filter_system_calls(); code != 0) return code;
    section.is_filtered = true;
  }
  section.is_inside = true;
  return 0;
}

void begin_tick(std::uint64_t tick) {
  section.tick = tick;
}

void leave() {
  section.is_inside = false;
}

void for_each(void (*visit)(void* context, const GuardEntry& entry), void* context) {
  const Violation* violation = newest.load(std::memory_order_acquire);
  for (; violation != nullptr; violation = violation->next) {
    const CallerText caller = first_caller(*violation);
    visit(context, {violation->call, violation->count.load(std::memory_order_relaxed),
                    violation->first_tick, caller.data()});
  }
}

}  // namespace

void note(Violation& violation) noexcept {
  if (!section.is_inside) return;
  if (violation.count.fetch_add(1, std::memory_order_relaxed) != 0) return;
  section.is_inside = false;  // what the unwinder calls is not the section's
  violation.first_tick = section.tick;
  unwind_into(violation);
  violation.next = newest.load(std::memory_order_relaxed);
  while (!newest.compare_exchange_weak(violation.next, &violation, std::memory_order_release,
                                       std::memory_order_relaxed)) {
  }
  section.is_inside = true;
}

}  // namespace stillgrid::realtime

// Found by its name: kGuardTableName.
extern "C"
    [[gnu::visibility("default")]] const stillgrid::realtime::GuardTable stillgrid_realtime_guard;
const stillgrid::realtime::GuardTable stillgrid_realtime_guard = {
    stillgrid::realtime::enter, stillgrid::realtime::begin_tick, stillgrid::realtime::leave,
    stillgrid::realtime::for_each};
