#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>

#include "haptic_server/run.hpp"
#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::haptic_server {

/// The ticks of real time, at whoever's pace: tick() is called once a period by the loop's own
/// thread, or by the device's through on_device_tick(). Never two at a time.
class RealTimeTicks {
 public:
  explicit RealTimeTicks(Run& run) : run_(run) {}

  /// One tick. False where the ticks are over: outcome() says how.
  ///
  /// Realtime: as HapticLoop, and the driver's read and write.
  [[nodiscard]] bool tick(const realtime::PeriodicTimer::Wake& wake);

  /// As stillgrid_device_tick_fn of a RealTimeTicks. The first of a thread makes it real-time as
  /// far as that may be had; one that comes while another is under way ends the ticks; while the
  /// device is being stopped, or must be activated anew, nothing is told to it.
  static std::int32_t on_device_tick(void* ticks) noexcept;

  /// The watchdog has stopped the device: activates it anew, no force, then a ramp. Not in a tick
  /// of the device's pace. Throws DeviceFault, DeviceError.
  void recover();

  /// For a device that is about to be active anew: ticks go on, the first of them on time. Pre: no
  /// tick can come.
  void resume() noexcept;

  /// Whether the run's time is over. Thread: any but the one that ticks, and while none ticks.
  [[nodiscard]] bool is_past_end() const noexcept {
    return end_ns_ != 0 && realtime::monotonic_ns() >= end_ns_;
  }
  /// Ticks that the device has called, to tell its pace. Thread: any.
  [[nodiscard]] std::uint64_t device_ticks() const noexcept {
    return device_ticks_.load(std::memory_order_relaxed);
  }

  /// Asks for what the device's thread was refused: an answer may take longer than a tick. Thread:
  /// any but the one that ticks.
  void complete_rights_of_device();

  /// No tick comes any more, and none is under way.
  void end() noexcept;

  /// Whether no tick will come. Thread: any.
  [[nodiscard]] bool is_over() const noexcept { return is_over_.load(std::memory_order_acquire); }
  /// How they ended; throws what a tick threw. Pre: is_over(), and the device is not active, or the
  /// caller is the thread that ticks.
  [[nodiscard]] TickEnd outcome() const;

 private:
  [[nodiscard]] bool goes_on() noexcept;
  [[nodiscard]] bool tick_at_device_pace();
  void enter_thread();

  Run& run_;
  std::uint64_t end_ns_ = 0;  // set by the first tick
  TickEnd end_ = TickEnd::kGoOn;
  recording::TickRow row_;
  std::uint64_t next_ns_ = 0;  // the device's next tick is due; 0: not known
  long faults_before_ = 0;     // page faults of thread_ before its second tick
  bool is_second_ = false;     // whether that one has come
  std::thread::id thread_;     // that ticks at the device's pace
  std::mutex rights_mutex_;    // of the report's rights, while the device sets the pace
  pid_t needs_rights_ = 0;     // a thread that has yet to be asked for; 0: none
  std::exception_ptr thrown_;
  std::atomic<std::uint64_t> stops_ = 0;  // by the watchdog, that were recovered from
  std::atomic<std::uint64_t> device_ticks_ = 0;
  std::atomic<bool> is_over_ = false, is_ticking_ = false;
  std::atomic<bool> ticked_twice_ = false;  // two threads at once
};

}  // namespace stillgrid::haptic_server
