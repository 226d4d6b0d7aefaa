#include "haptic_server/safety/tick_watchdog.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <utility>

namespace stillgrid {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kPoll = std::chrono::milliseconds(10);
/// A poll that took longer says nothing of the loop: the watchdog was not running either.
constexpr auto kLongestPoll = 3 * kPoll;
constexpr auto kPatience = std::chrono::nanoseconds(std::chrono::milliseconds(100));
constexpr auto kGiveUpAfter = std::chrono::seconds(1);
constexpr auto kLongestCall = std::chrono::seconds(10);

/// Above the loop's own priority; without the right to it, as any other thread.
void rise_above_loop() {
  sched_param priority{};
  priority.sched_priority = 81;
  static_cast<void>(::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority));
}

}  // namespace

TickWatchdog::TickWatchdog(std::uint64_t period_ns, std::function<void()> stop_device,
                           std::function<void()> give_up)
    : patience_(std::max(kPatience, 3 * std::chrono::nanoseconds(period_ns))),
      stop_device_(std::move(stop_device)),
      give_up_(std::move(give_up)),
      stopping_([this](const std::stop_token& end) { stop_when_asked(end); }),
      watching_([this](const std::stop_token& end) { keep_watch(end); }) {}

void TickWatchdog::stop_when_asked(const std::stop_token& end) {
  rise_above_loop();
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, end, [this] { return must_stop_; })) {
    must_stop_ = false;
    lock.unlock();
    stop_device_();
    stops_.fetch_add(1, std::memory_order_release);
    lock.lock();
  }
}

void TickWatchdog::keep_watch(const std::stop_token& end) {
  rise_above_loop();
  std::uint64_t seen = 0;
  bool has_asked = false;
  Clock::duration without_tick{};
  std::unique_lock lock(mutex_);
  for (auto before = Clock::now(); !end.stop_requested();) {
    changed_.wait_for(lock, end, kPoll, [] { return false; });
    const auto now = Clock::now();
    const auto poll = now - std::exchange(before, now);
    const Watched watched = watched_.load(std::memory_order_relaxed);
    if (const std::uint64_t ticks = ticks_.load(std::memory_order_relaxed); ticks != seen) {
      seen = ticks;
      without_tick = {};
      has_asked = false;
    } else if (poll <= kLongestPoll) {
      without_tick += poll;
    }
    if (watched == Watched::kTicks && without_tick >= patience_ && !has_asked) {
      has_asked = must_stop_ = true;
      changed_.notify_all();
    }
    const bool is_lost = (watched == Watched::kTicks && without_tick >= patience_ + kGiveUpAfter) ||
                         (watched == Watched::kCall && without_tick >= kLongestCall);
    if (is_lost) {
      lock.unlock();
      give_up_();
      return;
    }
  }
}

}  // namespace stillgrid
