#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "haptic_server/devices/plugin_support.hpp"

namespace stillgrid::devices {

/// The connection to spacenavd, the daemon that reads the mouse: a thread of its own takes the
/// events and leaves the newest state where the haptic loop reads it without a lock or a call.
///
/// libspnav holds one connection for the whole process, so there is one client at a time: a
/// second one is refused.
class SpacemouseClient {
 public:
  /// Connects, waiting up to 0.3 s for an old daemon, and starts the thread. The log is told
  /// when the mouse or the daemon goes.
  ///
  /// Throws DriverError with STILLGRID_DEVICE_E_NO_DEVICE where there is no daemon, or where there
  /// is a client already.
  explicit SpacemouseClient(const HostLog& log);
  ~SpacemouseClient();

  SpacemouseClient(const SpacemouseClient&) = delete;
  SpacemouseClient& operator=(const SpacemouseClient&) = delete;

  /// The cap's counts: x, y, z, rx, ry, rz. All zero once mouse or daemon is gone. Each is the
  /// newest, so two of them may be of two events that came during the call.
  ///
  /// Realtime: six loads.
  [[nodiscard]] std::array<int, 6> counts() const noexcept;

  /// The buttons that are down, a bit each, of the first 32. Counts that came before a press
  /// are seen by who sees the press.
  ///
  /// Realtime: one load.
  [[nodiscard]] std::uint32_t buttons() const noexcept {
    return buttons_.load(std::memory_order_acquire);
  }

  /// Whether the daemon still answers.
  ///
  /// Realtime: one load.
  [[nodiscard]] bool is_connected() const noexcept {
    return is_connected_.load(std::memory_order_acquire);
  }

 private:
  struct Connection {
    Connection();
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;
  };
  struct StopEvent {  // told by a write, for the thread waits in poll()
    StopEvent();
    ~StopEvent();
    StopEvent(const StopEvent&) = delete;
    StopEvent& operator=(const StopEvent&) = delete;

    int file;
  };

  void run();
  void take_event();
  void let_go() noexcept;

  HostLog log_;
  Connection connection_;
  StopEvent stop_;
  std::array<std::atomic<int>, 6> counts_{};
  std::atomic<std::uint32_t> buttons_ = 0;
  std::atomic<bool> is_connected_ = true;
  std::thread thread_;
};

}  // namespace stillgrid::devices
