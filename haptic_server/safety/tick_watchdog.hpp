#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

namespace stillgrid::safety {

/// Sees a loop that no longer ticks, and a driver that does not come back, from threads of its own.
///
/// While it watches ticks: without one for 100 ms, or three periods if that is longer, it calls
/// stop_device, for a held force must not outlive the loop that would change it. A second later it
/// calls give_up, whether or not stop_device has returned: a driver may hold a lock that its own
/// stop waits for. While it watches a call that may block it only gives up, after 10 s; while it
/// watches one that is to take the force away it calls stop_device after a second as well. A
/// stop_device that has not returned after 300 ms is given up at once. Time counts only while the
/// watchdog itself runs: a process that was stopped as a whole, or a machine that was, is no fault
/// of the loop, which sees its own gap.
///
/// Made before the loop's thread becomes real-time: on any processor, and above the loop's priority
/// where that may be had, it also runs beside a driver that spins.
class TickWatchdog {
 public:
  /// Watches nothing yet. beat: called every 10 ms for as long as the watchdog lives, until it
  /// gives up.
  TickWatchdog(
      std::uint64_t period_ns, std::function<void()> stop_device, std::function<void()> give_up,
      std::function<void()> beat = [] {});

  /// From now on ticks are due; a call is under way; one that is to release the device is; nothing
  /// is. Thread: the loop's. Realtime: yes.
  void watch_ticks() noexcept { watch(Watched::kTicks); }
  void watch_call() noexcept { watch(Watched::kCall); }
  void watch_release() noexcept { watch(Watched::kRelease); }
  void rest() noexcept { watch(Watched::kNothing); }

  /// The loop lives. Thread: the loop's. Realtime: wait-free.
  void tick() noexcept { ticks_.fetch_add(1, std::memory_order_relaxed); }

  /// Whether the device is being stopped, or given up: it may be told nothing as long as it is.
  /// Thread: any. Realtime: yes.
  [[nodiscard]] bool is_stopping() const noexcept {
    return is_stopping_.load(std::memory_order_acquire);
  }

  /// How often the device was stopped. Thread: any. Realtime: yes.
  [[nodiscard]] std::uint64_t stops() const noexcept {
    return stops_.load(std::memory_order_acquire);
  }

 private:
  enum class Watched { kNothing, kTicks, kCall, kRelease };

  struct Patience {
    std::chrono::nanoseconds until_stop, until_loss;
  };

  void watch(Watched what) noexcept {
    watched_.store(what, std::memory_order_relaxed);
    tick();
  }
  [[nodiscard]] Patience patience(Watched watched) const noexcept;
  void keep_watch(const std::stop_token& end);
  void stop_when_asked(const std::stop_token& end);

  std::chrono::nanoseconds longest_tick_;
  std::function<void()> stop_device_, give_up_, beat_;
  std::atomic<Watched> watched_ = Watched::kNothing;
  std::atomic<std::uint64_t> ticks_ = 0, stops_ = 0;
  std::atomic<bool> is_stopping_ = false;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  bool must_stop_ = false;            // guarded by mutex_
  std::jthread stopping_, watching_;  // last: joined before what they use is gone
};

}  // namespace stillgrid::safety
