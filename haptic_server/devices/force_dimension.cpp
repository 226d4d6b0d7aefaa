#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "haptic_server/devices/device_profile.hpp"
#include "haptic_server/devices/force_dimension_link.hpp"
#include "haptic_server/devices/force_dimension_state.hpp"
#include "haptic_server/devices/plugin_options.hpp"
#include "haptic_server/devices/plugin_support.hpp"
#include "haptic_server/devices/rigid_reading.hpp"
#include "haptic_server/devices/vendor_listing.hpp"

namespace stillgrid::devices {
namespace {

/// What ended the reading or the writing.
enum class Fault { kNone, kRead, kWrite, kBadValue, kLost };

bool switch_option(std::string_view key, std::string_view value) {
  return count_option(key, value, 1) == 1;
}

/// Force Dimension's omega, delta, sigma and Novint's Falcon, through the vendor's SDK at the
/// user's place. Polled by the host's thread: each read and write goes to the device.
class ForceDimensionDriver {
 public:
  static constexpr const char* kName = "force_dimension";

  explicit ForceDimensionDriver(const HostLoop& loop) : clock_(loop.clock), log_(loop.log) {}

  void configure(std::string_view key, std::string_view value) {
    if (key == "library") {
      choice_.library = value;
    } else if (key == "index") {
      choice_.index = static_cast<int>(count_option(key, value, 63));
    } else if (key == "serial") {
      choice_.serial = static_cast<int>(count_option(key, value, 65535));
    } else if (key == "gravity_compensation") {
      wants_gravity_compensation_ = switch_option(key, value);
    } else if (key == "watchdog_ms") {
      watchdog_ms_ = static_cast<int>(count_option(key, value, 31));
    } else {
      refuse_option(key, value,
                    "a known key: library, index, serial, gravity_compensation, watchdog_ms");
    }
    link_.reset();
  }

  void describe(stillgrid_device_descriptor& descriptor) {
    descriptor.flags = STILLGRID_DEVICE_USES_SYSCALLS;
    descriptor.max_read_ns = 500'000;
    link().describe(descriptor);
  }

  void identify(stillgrid_device_identity& identity) {
    copy_text(identity.serial, link().serial);
    copy_text(identity.driver,
              "stillgrid force_dimension " STILLGRID_VERSION ", SDK " + link().dhd.version);
  }

  [[nodiscard]] bool list(std::uint32_t index, stillgrid_device_listing& listing) {
    link_.reset();  // or it would be busy by us
    return list_force_dimension(choice_.library, index, listing);
  }

  void activate() {
    if (clock_ == STILLGRID_CLOCK_VIRTUAL)
      throw std::runtime_error("a real device has no virtual time: expected no lockstep");
    const ForceDimensionLink& device = link();
    fault_ = Fault::kNone;
    gripper_N_ = 0.0;
    set_watchdog(device);
    has_gravity_compensation_ = wants_gravity_compensation_;
    device.require(
        device.dhd.set_gravity_compensation(has_gravity_compensation_ ? 1 : 0, device.id),
        "gravity_compensation");
    device.require(device.dhd.enable_force(1, device.id), "motors on");
    device.require(send(kZero, kZero, 0.0), "zero force");
    device.require(device.dhd.set_brakes(0, device.id), "brakes off");
  }

  std::int32_t read(std::uint64_t now_ns, bool /*is_stopped*/,
                    stillgrid_device_state& state) noexcept {
    const ForceDimensionLink& device = *link_;
    Eigen::Vector3d position_m;
    if (device.dhd.get_position(&position_m[0], &position_m[1], &position_m[2], device.id) < 0)
      return fail(Fault::kRead);
    if (!is_position(position_m)) return fail(Fault::kBadValue);
    state.valid = STILLGRID_STATE_POSITION | STILLGRID_STATE_BUTTONS;
    state.time_ns = now_ns;
    state.sequence = ++sequence_;
    Eigen::Map<Eigen::Vector3d>(state.position_m) = position_m;
    state.buttons = device.dhd.get_button_mask(device.id);
    read_velocity(device, state);
    if (!read_wrist(device, state) || !read_gripper(device, state)) return STILLGRID_DEVICE_E_IO;
    return read_status(device, state);
  }

  std::int32_t write(std::uint64_t /*now_ns*/, bool is_stopped, const double* force_N,
                     const double* torque_N_m) noexcept {
    const ForceDimensionLink& device = *link_;
    const bool wants = wants_gravity_compensation_;
    if (wants != has_gravity_compensation_) {
      has_gravity_compensation_ = wants;
      device.dhd.set_gravity_compensation(wants ? 1 : 0, device.id);
    }
    Eigen::Vector3d force = Eigen::Map<const Eigen::Vector3d>(force_N);
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    if (device.has_active_wrist && torque_N_m != nullptr)
      torque = Eigen::Map<const Eigen::Vector3d>(torque_N_m);
    const bool is_bad = !force.allFinite() || !torque.allFinite();
    const bool is_zero = is_bad || is_stopped;
    if (is_zero) force = torque = Eigen::Vector3d::Zero();
    if (send(force, torque, is_zero ? 0.0 : gripper_N_) < 0) return fail(Fault::kWrite);
    return is_bad ? STILLGRID_DEVICE_E_ARGUMENT : STILLGRID_DEVICE_OK;
  }

  /// Sent with the next force: the SDK has one call for both.
  std::int32_t write_gripper(std::uint64_t /*now_ns*/, bool /*is_stopped*/,
                             double force_N) noexcept {
    const bool is_good = std::isfinite(force_N);
    gripper_N_ = is_good && link_->has_active_gripper ? force_N : 0.0;
    return is_good ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ARGUMENT;
  }

  /// Taken over by the thread that writes: nobody says that the SDK may be called by two.
  void command(std::string_view key, std::string_view value) {
    if (key != "gravity_compensation")
      refuse_option(key, value, "a known order: gravity_compensation");
    wants_gravity_compensation_ = switch_option(key, value);
  }

  void deactivate() noexcept {
    (void)send(kZero, kZero, 0.0);
    link_->dhd.stop(link_->id);
  }

  [[nodiscard]] const char* fault_line(std::int32_t code) noexcept {
    if (code != STILLGRID_DEVICE_E_IO || fault_ == Fault::kNone) return nullptr;
    const char* const what = fault_ == Fault::kRead    ? "the device does not answer"
                             : fault_ == Fault::kWrite ? "the device takes no force"
                             : fault_ == Fault::kLost
                                 ? "the device is gone: its controller is not connected"
                                 : "the vendor's library gave a pose that is no number or leads "
                                   "out of the room";
    const bool has_reason = fault_ == Fault::kRead || fault_ == Fault::kWrite;
    std::snprintf(line_.data(), line_.size(), "%s%s%s", what, has_reason ? ": " : "",
                  has_reason ? link_->dhd.error_get_str(error_) : "");
    return line_.data();
  }

 private:
  static inline const Eigen::Vector3d kZero = Eigen::Vector3d::Zero();

  ForceDimensionLink& link() {
    if (link_) return *link_;
    link_.emplace(choice_);
    if (profile_of(force_dimension_profiles(), link_->name) == nullptr)
      log_.warn("no limits of '" + link_->name + "' are known: limit its force by --max-force");
    return *link_;
  }

  void set_watchdog(const ForceDimensionLink& device) const {
    const ForceDimensionLibrary& dhd = device.dhd;
    const auto steps = static_cast<unsigned char>(8 * watchdog_ms_);
    bool is_set = false;
    if (dhd.set_watchdog != nullptr && dhd.enable_expert_mode != nullptr &&
        dhd.disable_expert_mode != nullptr && dhd.enable_expert_mode() >= 0) {
      is_set = dhd.set_watchdog(steps, device.id) >= 0;
      dhd.disable_expert_mode();
    }
    if (!is_set && watchdog_ms_ > 0)
      log_.warn("'" + device.name +
                "' has no watchdog: should this computer stand still, the last "
                "force stays");
  }

  [[nodiscard]] int send(const Eigen::Vector3d& force_N, const Eigen::Vector3d& torque_N_m,
                         double gripper_N) const noexcept {
    return link_->dhd.set_force_and_torque_and_gripper_force(force_N.x(), force_N.y(), force_N.z(),
                                                             torque_N_m.x(), torque_N_m.y(),
                                                             torque_N_m.z(), gripper_N, link_->id);
  }

  static void read_velocity(const ForceDimensionLink& device,
                            stillgrid_device_state& state) noexcept {
    Eigen::Vector3d velocity;
    if (device.dhd.get_linear_velocity(&velocity[0], &velocity[1], &velocity[2], device.id) < 0 ||
        !velocity.allFinite()) {
      return;
    }
    state.valid |= STILLGRID_STATE_VELOCITY;
    Eigen::Map<Eigen::Vector3d>(state.velocity_m_s) = velocity;
  }

  bool read_wrist(const ForceDimensionLink& device, stillgrid_device_state& state) noexcept {
    if (!device.has_wrist) return true;
    double rows[3][3]{};
    if (device.dhd.get_orientation_frame(rows, device.id) < 0) return note(Fault::kRead);
    const auto rotation =
        rotation_of(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&rows[0][0]));
    if (!rotation) return note(Fault::kBadValue);
    state.valid |= STILLGRID_STATE_ORIENTATION;
    Eigen::Map<Eigen::Vector4d>(state.orientation_xyzw) = rotation->coeffs();
    return true;
  }

  bool read_gripper(const ForceDimensionLink& device, stillgrid_device_state& state) noexcept {
    if (!device.has_gripper) return true;
    if (device.dhd.get_gripper_gap(&state.gripper_m, device.id) < 0) return note(Fault::kRead);
    if (!std::isfinite(state.gripper_m)) return note(Fault::kBadValue);
    state.valid |= STILLGRID_STATE_GRIPPER;
    return true;
  }

  std::int32_t read_status(const ForceDimensionLink& device,
                           stillgrid_device_state& state) noexcept {
    if (device.dhd.get_status(status_.data(), device.id) < 0) return fail(Fault::kRead);
    if (status_[kDhdConnected] == 0) return fail(Fault::kLost);
    state.status_known = kForceDimensionStatusKnown;
    state.status = status_bits(status_, device.has_active_wrist);
    return STILLGRID_DEVICE_OK;
  }

  bool note(Fault fault) noexcept {
    error_ = link_->dhd.error_get_last();  // here: it is this thread's
    fault_ = fault;
    return false;
  }
  std::int32_t fail(Fault fault) noexcept {
    note(fault);
    return STILLGRID_DEVICE_E_IO;
  }

  std::uint32_t clock_;
  HostLog log_;
  ForceDimensionChoice choice_;
  std::atomic<bool> wants_gravity_compensation_ = true;
  int watchdog_ms_ = 20;

  std::optional<ForceDimensionLink> link_;
  bool has_gravity_compensation_ = false;
  double gripper_N_ = 0.0;
  std::uint64_t sequence_ = 0;
  ForceDimensionStatus status_{};
  Fault fault_ = Fault::kNone;
  int error_ = 0;
  std::array<char, 512> line_{};
};

}  // namespace
}  // namespace stillgrid::devices

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  using stillgrid::devices::ForceDimensionDriver;
  return stillgrid::devices::PluginAdapter<ForceDimensionDriver>::negotiate(host, out);
}
