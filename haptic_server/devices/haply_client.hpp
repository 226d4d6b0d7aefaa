#pragma once

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "haptic_server/devices/driver_host.hpp"
#include "haptic_server/devices/haply_connection.hpp"
#include "haptic_server/devices/haply_echo.hpp"
#include "haptic_server/devices/haply_protocol.hpp"
#include "haptic_server/devices/haply_stop.hpp"
#include "haptic_server/devices/mailbox.hpp"

namespace stillgrid::devices {

/// What is known of arm and grip at a moment.
struct HaplySample {
  std::uint64_t time_ns = 0;  // when the service's reply had come, CLOCK_MONOTONIC
  std::uint64_t sequence = 0;
  std::array<double, 3> position_m{};
  std::array<double, 3> velocity_m_s{};
  std::array<double, 4> orientation_xyzw{};
  bool has_orientation = false;
  std::uint32_t buttons = 0;
  std::uint32_t status = 0;
  std::uint32_t status_known = 0;
};

/// Which of the service's devices is driven, and by whom.
struct HaplyChoice {
  std::string arm;
  std::string grip;  // empty: none
  HaplySpelling spelling = HaplySpelling::kVector;
  std::uint64_t period_ns = 1'000'000;
  HostTick tick{};  // none: the host's thread reads and writes by itself
};

/// The conversation with the service, in a thread of its own: a message with the force, its reply
/// with the state, and so on. Where there is a tick the thread calls it, once a period or as fast
/// as the service answers, with a state that is one round trip old; where there is none the newest
/// values go to and fro without a lock.
class HaplyClient {
 public:
  static constexpr std::chrono::milliseconds kSilence{80};  // the host gives up a device after 100

  /// Sends zero force and takes the first state. The emergency stop reaches the service through
  /// `stop`. Throws HaplyConnectionError or HaplyProtocolError.
  HaplyClient(std::unique_ptr<HaplyConnection> connection, HaplyChoice choice, HaplyStop& stop,
              const HostLog& log);

  /// As release().
  ~HaplyClient();

  HaplyClient(const HaplyClient&) = delete;
  HaplyClient& operator=(const HaplyClient&) = delete;

  /// Starts the thread, which may tick before this returns.
  void start();

  /// The newest state. Realtime: a load.
  [[nodiscard]] const HaplySample& sample() noexcept { return samples_.take(); }

  /// The force from now on, for 50 ms at most. Realtime: a copy. Pre: finite.
  void command(std::uint64_t now_ns, const Eigen::Vector3d& force_N) noexcept {
    commands_.put({now_ns, {force_N.x(), force_N.y(), force_N.z()}});
  }

  /// Whether the conversation has ended by a fault. Realtime: one load.
  [[nodiscard]] bool has_failed() const noexcept {
    return has_failed_.load(std::memory_order_acquire);
  }

  /// The fault in one line. Pre: has_failed().
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

  /// Ends the conversation with zero force. False where the service did not confirm it.
  bool release() noexcept;

 private:
  struct Command {
    std::uint64_t time_ns = 0;
    std::array<double, 3> force_N{};
  };

  void run(const std::stop_token& end) noexcept;
  void converse(const std::stop_token& end);
  void end_in_fault(const std::stop_token& end, const std::string& line) noexcept;
  void exchange(const Eigen::Vector3d& force_N);
  void take(const HaplyMessage& message, std::uint64_t now_ns);
  void judge(const Eigen::Vector3d& heard_N);
  void send(const Eigen::Vector3d& force_N);
  [[nodiscard]] Eigen::Vector3d force_now() noexcept;

  std::string text_;  // of the message that is being sent
  std::unique_ptr<HaplyConnection> connection_;
  HaplyChoice choice_;
  HaplyStop& stop_;
  HostLog log_;
  HaplyEcho echo_;
  HaplySample newest_;
  Eigen::Vector3d heard_N_ = Eigen::Vector3d::Zero();
  std::uint64_t round_trip_ns_ = 0;  // smoothed
  std::uint64_t timely_ns_ = 0;      // when a reply was last in time
  int ramp_ = 0;                     // replies until the whole force is sent
  bool has_other_spelling_ = true;   // not tried yet
  bool misses_grip_ = false;
  bool is_ticked_ = false;
  Mailbox<HaplySample> samples_;
  Mailbox<Command> commands_;
  std::atomic<bool> has_failed_ = false;
  bool is_released_ = false;  // zero force was confirmed at the end
  std::string fault_;
  std::jthread thread_;
};

/// CLOCK_MONOTONIC.
[[nodiscard]] std::uint64_t monotonic_ns() noexcept;

}  // namespace stillgrid::devices
