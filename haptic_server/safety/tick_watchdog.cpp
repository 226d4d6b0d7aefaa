#include "haptic_server/safety/tick_watchdog.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <utility>

namespace stillgrid::safety {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kPoll = std::chrono::milliseconds(10);
/// A poll that took longer says nothing of the loop: the watchdog was not running either.
constexpr auto kLongestPoll = 3 * kPoll;
constexpr auto kLongestTick = std::chrono::nanoseconds(std::chrono::milliseconds(100));
constexpr auto kGiveUpAfter = std::chrono::seconds(1);
constexpr auto kLongestStop = std::chrono::milliseconds(300);
constexpr auto kStopReleaseAfter = std::chrono::seconds(1);
constexpr auto kLongestCall = std::chrono::seconds(10);
constexpr auto kNever = std::chrono::nanoseconds::max();

/// Above the loop's own priority; without the right to it, as any other thread.
void rise_above_loop() {
  sched_param priority{};
  priority.sched_priority = 81;
  static_cast<void>(::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority));
}

}  // namespace

TickWatchdog::TickWatchdog(std::uint64_t period_ns, std::function<void()> stop_device,
                           std::function<void()> give_up, std::function<void()> beat)
    : longest_tick_(std::max(kLongestTick, 3 * std::chrono::nanoseconds(period_ns))),
      stop_device_(std::move(stop_device)),
      give_up_(std::move(give_up)),
      beat_(std::move(beat)),
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
    is_stopping_.store(false, std::memory_order_release);
    lock.lock();
  }
}

TickWatchdog::Patience TickWatchdog::patience(Watched watched) const noexcept {
  switch (watched) {
    case Watched::kTicks:
      return {longest_tick_, longest_tick_ + kGiveUpAfter};
    case Watched::kCall:
      return {kNever, kLongestCall};
    case Watched::kRelease:
      return {kStopReleaseAfter, kLongestCall};
    case Watched::kNothing:
      break;
  }
  return {kNever, kNever};
}

void TickWatchdog::keep_watch(const std::stop_token& end) {
  rise_above_loop();
  std::uint64_t seen = 0;
  bool has_asked = false;
  Clock::duration without_tick{}, stopping{};
  std::unique_lock lock(mutex_);
  // Not before a stop that is under way has returned, which the other thread's end waits for.
  for (auto before = Clock::now(); !end.stop_requested() || is_stopping();) {
    if (!changed_.wait_for(lock, end, kPoll, [] { return false; }) && end.stop_requested())
      std::this_thread::sleep_for(kPoll);
    beat_();
    const auto now = Clock::now();
    const auto poll = now - std::exchange(before, now);
    const auto counted = poll <= kLongestPoll ? poll : Clock::duration{};
    if (const std::uint64_t ticks = ticks_.load(std::memory_order_relaxed);
        std::exchange(seen, ticks) != ticks) {
      without_tick = {};
      has_asked = false;
    } else {
      without_tick += counted;
    }
    stopping = is_stopping() ? stopping + counted : Clock::duration{};
    const auto [until_stop, until_loss] = patience(watched_.load(std::memory_order_relaxed));
    if (without_tick >= until_stop && !has_asked && !is_stopping()) {
      has_asked = must_stop_ = true;
      is_stopping_.store(true, std::memory_order_release);
      changed_.notify_all();
    }
    if (without_tick >= until_loss || stopping >= kLongestStop) {
      is_stopping_.store(true, std::memory_order_release);  // for good
      lock.unlock();
      give_up_();
      return;
    }
  }
}

}  // namespace stillgrid::safety
