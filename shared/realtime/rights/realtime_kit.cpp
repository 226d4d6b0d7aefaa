// RealtimeKit 0.13: org.freedesktop.RealtimeKit1 on the system's bus. A thread that wants its
// priority has RLIMIT_RTTIME first, so that it cannot keep a processor from everybody else.
#include <sched.h>
#include <sys/resource.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "shared/realtime/rights/realtime_rights.hpp"

namespace stillgrid::realtime {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLongestWait = std::chrono::seconds(1);
constexpr const char* kName = "org.freedesktop.RealtimeKit1";
constexpr const char* kPath = "/org/freedesktop/RealtimeKit1";
constexpr std::int32_t kMaxPriority = 20;  // as its makers mean it; a bus may answer anything
constexpr std::int64_t kMaxTime_us = 200'000, kMinTime_us = 1'000;

struct BusEnd {
  void operator()(sd_bus* bus) const noexcept { sd_bus_close_unref(bus); }
};
using Bus = std::unique_ptr<sd_bus, BusEnd>;

/// sd_bus's own error, freed at the end.
struct BusError {
  BusError() = default;
  ~BusError() { sd_bus_error_free(&error); }
  BusError(const BusError&) = delete;
  BusError& operator=(const BusError&) = delete;
  [[nodiscard]] std::string text(int code) const {
    return error.message != nullptr ? error.message : std::strerror(-code);
  }
  sd_bus_error error = {};
};

static_assert(std::atomic<pid_t>::is_always_lock_free);
std::atomic<pid_t> granted_thread = 0;
std::atomic<bool> is_demoted = false;

/// The loop has run for half of what it may without a rest: what the watchdog does about that, it
/// does; the kernel's SIGKILL would be worse for the hand.
void demote(int /*signal*/) {
  if (granted_thread == 0) return;
  const int error = errno;
  const sched_param none{};
  // RESET_ON_FORK may only be cleared by root.
  if (::sched_setscheduler(granted_thread, SCHED_OTHER | SCHED_RESET_ON_FORK, &none) == 0)
    is_demoted = true;
  errno = error;
}

std::uint64_t left_us(Clock::time_point end) {
  const auto left = std::chrono::duration_cast<std::chrono::microseconds>(end - Clock::now());
  return static_cast<std::uint64_t>(std::max<std::int64_t>(left.count(), 1));
}

/// sd_bus alone would wait 90 s for a bus that lets us in and says nothing.
int wait_until_ready(sd_bus& bus, Clock::time_point end) {
  for (;;) {
    if (const int ready = sd_bus_is_ready(&bus); ready != 0) return ready;
    const int done = sd_bus_process(&bus, nullptr);
    if (done < 0) return done;
    if (done > 0) continue;
    if (Clock::now() >= end) return -ETIMEDOUT;
    if (const int waited = sd_bus_wait(&bus, left_us(end)); waited < 0 && waited != -EINTR)
      return waited;
  }
}

/// A number of RealtimeKit's; type is D-Bus's letter of T.
template <class T>
int read_property(sd_bus& bus, const char* name, char type, Clock::time_point end, T& value,
                  BusError& error) {
  sd_bus_set_method_call_timeout(&bus, left_us(end));
  return sd_bus_get_property_trivial(&bus, kName, kPath, kName, name, &error.error, type, &value);
}

/// Half of it until SIGXCPU, all of it until SIGKILL. A limit is only ever lowered.
bool limit_time_without_rest(std::int64_t max_us) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_RTTIME, &limit) != 0) return false;
  limit.rlim_max = std::min<rlim_t>(limit.rlim_max, static_cast<rlim_t>(max_us));
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_cur, limit.rlim_max / 2);
  struct sigaction action {};
  action.sa_handler = demote;
  action.sa_flags = SA_RESTART;
  return ::sigaction(SIGXCPU, &action, nullptr) == 0 && ::setrlimit(RLIMIT_RTTIME, &limit) == 0;
}

/// The priority that it granted, or 0 and why not.
int grant(pid_t thread, std::string& refusal) {
  const Clock::time_point end = Clock::now() + kLongestWait;
  BusError error;
  sd_bus* opened = nullptr;
  int code = sd_bus_open_system(&opened);
  const Bus bus(opened);
  if (code >= 0) code = wait_until_ready(*bus, end);
  if (code < 0) return refusal = "no system bus: " + error.text(code), 0;

  std::int32_t priority = 0;
  std::int64_t time_us = 0;
  code = read_property(*bus, "MaxRealtimePriority", 'i', end, priority, error);
  if (code >= 0) code = read_property(*bus, "RTTimeUSecMax", 'x', end, time_us, error);
  if (code < 0) return refusal = error.text(code), 0;
  if (priority < 1 || time_us < kMinTime_us)
    return refusal = "it allows priority " + std::to_string(priority) + " for " +
                     std::to_string(time_us) + " us; expected 1 and 1000 at least",
           0;
  priority = std::min(priority, kMaxPriority);
  if (!limit_time_without_rest(std::min(time_us, kMaxTime_us)))
    return refusal = std::string("RLIMIT_RTTIME: ") + std::strerror(errno), 0;

  sd_bus_set_method_call_timeout(bus.get(), left_us(end));
  code = sd_bus_call_method(bus.get(), kName, kPath, kName, "MakeThreadRealtime", &error.error,
                            nullptr, "tu", static_cast<std::uint64_t>(thread),
                            static_cast<std::uint32_t>(priority));
  if (code < 0) return refusal = error.text(code), 0;
  sched_param got{};
  const int policy = ::sched_getscheduler(thread) & ~SCHED_RESET_ON_FORK;
  if ((policy != SCHED_RR && policy != SCHED_FIFO) || ::sched_getparam(thread, &got) != 0)
    return refusal = "it granted a priority, and the thread has none", 0;
  granted_thread = thread;
  return got.sched_priority;
}

}  // namespace

void ask_realtime_kit(RealtimeRights& rights, pid_t thread) {
  if (rights.way != RealtimeRights::Way::kNone) return;
  const int priority = grant(thread, rights.refusal);
  if (priority == 0) return;
  rights.way = RealtimeRights::Way::kRealtimeKit;
  rights.priority = priority;
  rights.refusal.clear();
}

bool was_demoted() noexcept {
  return is_demoted;
}

}  // namespace stillgrid::realtime
