#pragma once

#include <atomic>
#include <string>
#include <string_view>

namespace stillgrid::devices {

/// The emergency stop's own way to the service: a message with zero force that any thread sends at
/// once, whatever the thread of the conversation does, be it hung in the host's tick.
class HaplyStop {
 public:
  /// Throws DriverError where no file can be opened.
  HaplyStop();
  ~HaplyStop();
  HaplyStop(const HaplyStop&) = delete;
  HaplyStop& operator=(const HaplyStop&) = delete;

  /// From now on it goes to this connection and arm, and no stop is remembered.
  /// Pre: no stop() meanwhile changes hands: activate() alone calls it.
  void arm(int socket, std::string_view arm);

  /// Zero force at once, and no stop. Thread: any; pre: arm() was called.
  void send_zero() const noexcept;

  /// Zero force at once. Thread: any. Safe in a signal handler: one store, one send that never
  /// waits.
  void stop() noexcept;

  /// Whether stop() was called since arm(). Realtime: one load.
  [[nodiscard]] bool is_stopped() const noexcept { return is_stopped_.load(); }

 private:
  int file_;            // its number stays, so that a stop never meets a stranger's file
  std::string frames_;  // whole before is_armed_, and left alone while it is
  std::atomic<bool> is_armed_ = false;
  std::atomic<bool> is_stopped_ = false;
};

}  // namespace stillgrid::devices
