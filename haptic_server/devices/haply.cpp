#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "haptic_server/devices/haply_client.hpp"
#include "haptic_server/devices/haply_connection.hpp"
#include "haptic_server/devices/haply_protocol.hpp"
#include "haptic_server/devices/haply_stop.hpp"
#include "haptic_server/devices/plugin_options.hpp"
#include "haptic_server/devices/plugin_support.hpp"

namespace stillgrid::devices {
namespace {

// The maker's figures are on no page that we could read: what others do with the device.
constexpr double kMaxForce_N = 5.0;                   // SofaHaplyRobotics sends no more on an axis
constexpr double kNominalStiffness_N_per_m = 1000.0;  // of the floor in the maker's tutorial 04
constexpr std::string_view kNoGrip = "none";
constexpr std::chrono::milliseconds kInventory{2000};

template <std::size_t Size>
void put(char (&field)[Size], const std::string& text) {
  std::strncpy(field, text.c_str(), Size - 1);
}

template <class Devices>
std::string ids_of(const Devices& devices) {
  std::string ids;
  for (const auto& device : devices) ids += (ids.empty() ? "" : ", ") + device.id;
  return ids;
}

/// An Inverse3 by Haply Robotics behind its maker's service, with the VerseGrip that is held in it.
class HaplyDriver {
 public:
  static constexpr const char* kName = "haply";

  explicit HaplyDriver(const HostLoop& loop) : loop_(loop) {}

  void configure(std::string_view key, std::string_view value) {
    inventory_.reset();
    if (key == "address") {
      address_ = value;
    } else if (key == "port") {
      port_ = static_cast<std::uint16_t>(
          count_option(key, value, std::numeric_limits<std::uint16_t>::max()));
      if (port_ == 0) refuse_option(key, value, "a port, 1 to 65535");
    } else if (key == "device_id" || key == "grip_id") {
      if (!is_haply_id(value)) refuse_option(key, value, "an id as --list-devices shows it");
      (key == "device_id" ? device_id_ : grip_id_) = value;
    } else {
      refuse_option(key, value, "a known key: address, port, device_id, grip_id");
    }
  }

  void describe(stillgrid_device_descriptor& descriptor) {
    constexpr std::uint32_t kTranslation = STILLGRID_DOF_X | STILLGRID_DOF_Y | STILLGRID_DOF_Z;
    const HaplyMessage& message = inventory();
    const HaplyGrip* const grip = message.grip(choose_grip(message));
    (void)choose_arm(message);
    descriptor.flags = STILLGRID_DEVICE_SETS_PACE;
    descriptor.max_force_N = kMaxForce_N;
    descriptor.max_torque_N_m = 0.1 * kMaxForce_N;  // ignored: no motors turn the grip
    descriptor.nominal_stiffness_N_per_m = kNominalStiffness_N_per_m;
    descriptor.max_read_ns = 50'000;
    descriptor.dof_actuated = kTranslation;
    descriptor.dof_sensed = kTranslation;
    if (grip == nullptr) return;
    descriptor.dof_sensed |= STILLGRID_DOF_ABOUT_X | STILLGRID_DOF_ABOUT_Y | STILLGRID_DOF_ABOUT_Z;
    descriptor.button_count = grip->button_count;
  }

  void identify(stillgrid_device_identity& identity) {
    const HaplyArm& arm = choose_arm(inventory());
    put(identity.serial, arm.id);
    put(identity.firmware, arm.firmware);
    put(identity.driver, "stillgrid haply " STILLGRID_VERSION);
  }

  bool list(std::uint32_t index, stillgrid_device_listing& listing) {
    if (index == 0) inventory_.reset();
    const HaplyMessage& message = inventory();
    if (index >= message.arms.size()) return false;
    const HaplyArm& arm = message.arms[index];
    put(listing.name, arm.type.empty() ? "inverse3" : arm.type);
    put(listing.serial, arm.id);
    std::string options = "device_id=" + arm.id;
    if (address_ != kAddress) options += ",address=" + address_;
    if (port_ != kPort) options += ",port=" + std::to_string(port_);
    put(listing.options, options);
    return true;
  }

  void set_tick(HostTick tick) noexcept { tick_ = tick; }

  void activate() {
    if (loop_.clock == STILLGRID_CLOCK_VIRTUAL)
      throw std::runtime_error("a real device has no virtual time: expected no lockstep");
    client_.reset();
    try {
      auto connection = std::make_unique<HaplyConnection>(address_, port_);
      inventory_ = read_haply_message(connection->receive(kInventory));
      const HaplyArm& arm = choose_arm(*inventory_);
      stop_.arm(connection->socket(), arm.id);
      client_ = std::make_unique<HaplyClient>(
          std::move(connection),
          HaplyChoice{arm.id, choose_grip(*inventory_), arm.spelling, loop_.period_ns, tick_},
          stop_, loop_.log);
      client_->start();
    } catch (const HaplyConnectionError& error) {
      throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE, error.what());
    } catch (const HaplyProtocolError& error) {
      throw DriverError(STILLGRID_DEVICE_E_IO, error.what());
    }
  }

  std::int32_t read(std::uint64_t /*now_ns*/, bool /*is_stopped*/,
                    stillgrid_device_state& state) noexcept {
    const HaplySample& sample = client_->sample();
    state.valid = STILLGRID_STATE_POSITION | STILLGRID_STATE_VELOCITY | STILLGRID_STATE_BUTTONS;
    state.time_ns = sample.time_ns;
    state.sequence = sample.sequence;
    std::copy(sample.position_m.begin(), sample.position_m.end(), state.position_m);
    std::copy(sample.velocity_m_s.begin(), sample.velocity_m_s.end(), state.velocity_m_s);
    if (sample.has_orientation) {
      state.valid |= STILLGRID_STATE_ORIENTATION;
      std::copy(sample.orientation_xyzw.begin(), sample.orientation_xyzw.end(),
                state.orientation_xyzw);
    }
    state.buttons = sample.buttons;
    state.status = sample.status;
    state.status_known = sample.status_known;
    return client_->has_failed() ? STILLGRID_DEVICE_E_IO : STILLGRID_DEVICE_OK;
  }

  std::int32_t write(std::uint64_t now_ns, bool /*is_stopped*/, const double* force_N,
                     const double* /*torque_N_m*/) noexcept {
    Eigen::Vector3d force = Eigen::Map<const Eigen::Vector3d>(force_N);
    const bool is_finite = force.allFinite();
    if (!is_finite) force.setZero();
    const double norm_N = force.stableNorm();
    if (norm_N > kMaxForce_N) force *= kMaxForce_N / norm_N;
    client_->command(now_ns, force);
    if (client_->has_failed()) return STILLGRID_DEVICE_E_IO;
    return is_finite ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ARGUMENT;
  }

  void emergency_stop() noexcept { stop_.stop(); }

  /// A fault that read() or write() has told is not told again.
  std::int32_t deactivate() noexcept {
    const bool is_released = client_->release();
    return is_released || client_->has_failed() ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_IO;
  }

  const char* fault_line(std::int32_t code) const noexcept {
    if (code != STILLGRID_DEVICE_E_IO || client_ == nullptr) return nullptr;
    return client_->has_failed() ? client_->fault().c_str()
                                 : "the service did not confirm zero force within 200 ms";
  }

 private:
  static constexpr std::string_view kAddress = "127.0.0.1";
  static constexpr std::uint16_t kPort = 10001;

  /// What the service lists, asked once.
  const HaplyMessage& inventory() {
    if (!inventory_) {
      try {
        HaplyConnection connection(address_, port_);
        inventory_ = read_haply_message(connection.receive(kInventory));
      } catch (const HaplyConnectionError& error) {
        throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE, error.what());
      } catch (const HaplyProtocolError& error) {
        throw DriverError(STILLGRID_DEVICE_E_IO, error.what());
      }
    }
    return *inventory_;
  }

  [[nodiscard]] const HaplyArm& choose_arm(const HaplyMessage& message) const {
    if (message.arms.empty())
      throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                        "the service lists no Inverse3: expected one plugged in and switched on");
    const HaplyArm* const named = message.arm(device_id_);
    if (named == nullptr && !device_id_.empty())
      throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE, "the service lists no device " + device_id_ +
                                                          ", but " + ids_of(message.arms));
    if (named == nullptr && message.arms.size() > 1)
      throw std::runtime_error("several devices: expected device_id= one of " +
                               ids_of(message.arms));
    const HaplyArm& arm = named != nullptr ? *named : message.arms.front();
    if (!arm.foreign_frame.empty())
      throw std::runtime_error("the service moves the frame of device " + arm.id + " by " +
                               arm.foreign_frame + ": expected the device's own");
    return arm;
  }

  [[nodiscard]] std::string choose_grip(const HaplyMessage& message) const {
    if (grip_id_ == kNoGrip) return "";
    if (!grip_id_.empty() && message.grip(grip_id_) == nullptr)
      throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                        "the service lists no grip " + grip_id_ +
                            (message.grips.empty() ? "" : ", but " + ids_of(message.grips)));
    if (!grip_id_.empty()) return grip_id_;
    if (message.grips.size() > 1)
      throw std::runtime_error("several grips: expected grip_id= none or one of " +
                               ids_of(message.grips));
    return message.grips.empty() ? "" : message.grips.front().id;
  }

  HostLoop loop_;
  HaplyStop stop_;
  std::string address_{kAddress};
  std::uint16_t port_ = kPort;
  std::string device_id_;
  std::string grip_id_;
  HostTick tick_;
  std::optional<HaplyMessage> inventory_;
  std::unique_ptr<HaplyClient> client_;
};

}  // namespace
}  // namespace stillgrid::devices

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  return stillgrid::devices::PluginAdapter<stillgrid::devices::HaplyDriver>::negotiate(host, out);
}
