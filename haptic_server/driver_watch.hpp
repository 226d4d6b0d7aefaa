#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <thread>

#include "shared/realtime/process_state.hpp"

namespace stillgrid::haptic_server {

/// Says, from a thread of its own, what is wrong with a device while the loop runs: one line at the
/// first of each kind, one at the end with how often.
///
/// Kinds: each reason for which a reading was not believed, and for which the device takes no
/// force, counted in ticks; what a driver may not change of the process (signal mask, umask,
/// folder, scheduling: looked at once a second; rounding mode: each tick, and set back). Thread:
/// but for note() the one that made it.
class DriverWatch {
 public:
  /// device: as lines are to name it. Made in the loop's thread, before any driver runs.
  explicit DriverWatch(std::string device);
  /// Says what has not been said, and the counts.
  ~DriverWatch();

  DriverWatch(const DriverWatch&) = delete;
  DriverWatch& operator=(const DriverWatch&) = delete;

  /// A tick has ended with these flags. Thread: the loop's. Realtime: wait-free, makes no system
  /// call.
  void note(std::uint32_t flags) noexcept;

 private:
  static constexpr std::size_t kRoundingMode = realtime::kProcessParts.size();
  static constexpr std::size_t kChanges = kRoundingMode + 1;

  void keep_watch(const std::stop_token& end);
  void look_at_process();
  void say_new();

  std::string device_;
  realtime::ProcessState before_;
  bool has_schedule_ = false;  // of the loop's thread, real-time only once it ticks
  std::array<std::atomic<std::uint64_t>, 32> bad_ticks_{};  // by the bit of the reason
  std::atomic<std::uint64_t> ticks_ = 0, unbelieved_ = 0;
  std::array<std::atomic<std::uint64_t>, kChanges> changes_{};
  std::uint64_t said_ = 0;  // bit by bit, reasons and then changes
  std::jthread thread_;     // last: joined before what it uses is gone
};

}  // namespace stillgrid::haptic_server
