#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

namespace stillgrid::devices {

/// A vendor's servo thread: it calls once a period, and after a stall goes on at the next deadline.
class PhantomServo {
 public:
  PhantomServo() = default;
  ~PhantomServo() { end(); }
  PhantomServo(const PhantomServo&) = delete;
  PhantomServo& operator=(const PhantomServo&) = delete;

  /// From now on work(now_ns), CLOCK_MONOTONIC, until it returns false or end(). At real-time
  /// priority where that may be had. Pre: not begun. Throws std::system_error.
  void begin(std::uint64_t period_ns, std::function<bool(std::uint64_t now_ns)> work);

  /// Waits for the call that is under way. Nothing where it was not begun.
  void end() noexcept;

 private:
  std::atomic<bool> is_ended_ = false;
  std::thread thread_;
};

}  // namespace stillgrid::devices
