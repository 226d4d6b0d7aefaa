#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>

#include "haptic_server/device/device_identity.hpp"
#include "haptic_server/device/device_spec.hpp"
#include "proto/device_plugin.h"

namespace stillgrid::device {

/// How the host will call the device.
struct DeviceLoop {
  std::uint64_t period_ns = 1'000'000;  // > 0
  bool is_virtual = false;              // lockstep: time starts at zero, a period a tick
  std::string session = {};             // name of the session, if there is one
};

/// A device that is open, and active from activate() to deactivate().
///
/// The plugin's library stays loaded for good. Neither copied nor moved.
class Device {
 public:
  /// Loads the plugin, configures it in the order of its options and asks what it is. Its motors
  /// stay off.
  ///
  /// Throws DeviceError.
  Device(const DeviceSpec& spec, const DeviceLoop& loop);

  /// Closes the device and opens it again with the same options, its motors off. Until that has
  /// succeeded it is closed: what is told to it is lost, and activate() fails. Thread: the one that
  /// made it, while nobody reads or writes.
  ///
  /// Throws DeviceError, also where another device came: other name, serial number or limits.
  void reopen();

  /// Deactivates, which leaves zero force, and closes.
  ~Device();

  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  /// Returns the device's own description. Its figures are finite and not negative, and its name is
  /// one line of UTF-8.
  [[nodiscard]] const stillgrid_device_descriptor& descriptor() const noexcept {
    return descriptor_;
  }

  /// Which device it is; empty where the driver does not offer stillgrid.device.identity/1.
  [[nodiscard]] const DeviceIdentity& identity() const noexcept { return identity_; }

  /// Whether the device's own thread calls the tick once a period, and the host so not its read()
  /// and write() at its own pace. Never in virtual time.
  [[nodiscard]] bool sets_pace() const noexcept { return sets_pace_; }

  /// The tick that a device calls that sets the pace, from activate() until deactivate() has
  /// returned. tick and context: good for as long as the process lives. Pre: sets_pace(). Throws
  /// DeviceError.
  void set_tick(stillgrid_device_tick_fn tick, void* context);

  /// Motors on, zero force. Not for the haptic loop while it renders. Throws DeviceError.
  void activate();

  /// The state at now_ns, or the driver's code: STILLGRID_DEVICE_END, or a fault. On a fault
  /// state.valid is zero. A driver that throws, or writes past the state's struct_size, counts as
  /// STILLGRID_DEVICE_E_IO.
  ///
  /// Realtime: the driver's read() and nothing else.
  [[nodiscard]] std::int32_t read(std::uint64_t now_ns, stillgrid_device_state& state) noexcept;

  /// Force and torque on the user's hand from now_ns on, device frame. Returns the driver's code.
  /// Once an emergency stop has begun the driver is told nothing until the next activate().
  ///
  /// Realtime: the driver's write() and nothing else.
  [[nodiscard]] std::int32_t write(std::uint64_t now_ns, const Eigen::Vector3d& force_N,
                                   const Eigen::Vector3d& torque_N_m) noexcept;

  /// The force on the gripper's fingers from now_ns on, positive opens it; nothing for a device
  /// that has none. Realtime: as write().
  [[nodiscard]] std::int32_t write_gripper(std::uint64_t now_ns, double force_N) noexcept;

  /// An order to the active device while ticks go on. The driver's refusal, one line; empty: done.
  /// Thread: any but those of ticks; waits while the device is activated, deactivated or closed.
  [[nodiscard]] std::string command(const std::string& key, const std::string& value);

  /// Zero force, motors off; later reads and writes return STILLGRID_DEVICE_E_ORDER. Returns the
  /// driver's code: but for STILLGRID_DEVICE_OK the motors may still be on. Called twice, it does
  /// nothing twice.
  std::int32_t deactivate() noexcept;

  /// Zero force at once, until the device was deactivated and is activated again. From any thread
  /// while the device lives.
  void emergency_stop() noexcept;

  [[nodiscard]] bool is_active() const noexcept { return is_active_; }

  /// One line on a code that read() or write() returned. Not for the haptic loop.
  [[nodiscard]] std::string error_line(std::int32_t code) const;

 private:
  void open();
  void configure(const DeviceOption& option);
  void describe();
  void identify();
  void close() noexcept;
  void require_rate(const DeviceLoop& loop) const;
  void require(std::int32_t code, const std::string& step) const;

  DeviceSpec spec_;
  std::string plugin_;  // as the user named it
  stillgrid_device_api api_{};
  stillgrid_device_descriptor descriptor_{};
  DeviceIdentity identity_;
  std::atomic<stillgrid_device*> device_ = nullptr;  // null: closed
  std::mutex commanding_;                            // not held by a tick
  bool sets_pace_ = false;
  stillgrid_device_tick_fn tick_ = nullptr;
  void* tick_context_ = nullptr;
  std::atomic<bool> is_active_ = false;
  std::atomic<bool> is_stopped_ = false;
};

}  // namespace stillgrid::device
