#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "haptic_server/devices/openhaptics_link.hpp"
#include "haptic_server/devices/openhaptics_servo.hpp"
#include "haptic_server/devices/plugin_options.hpp"
#include "haptic_server/devices/plugin_support.hpp"
#include "haptic_server/devices/vendor_listing.hpp"

namespace stillgrid::devices {
namespace {

/// 3D Systems' Touch, Touch X, Omni and Premium, through the vendor's OpenHaptics at the user's
/// place. Its scheduler's thread sets the pace; positions and forces stay in the device's frame.
class OpenHapticsDriver {
 public:
  static constexpr const char* kName = "openhaptics";

  explicit OpenHapticsDriver(const HostLoop& loop) : loop_(loop) {}

  void configure(std::string_view key, std::string_view value) {
    if (key == "library") {
      choice_.library = value;
    } else if (key == "name") {
      choice_.name = value;
    } else if (key == "serial") {
      choice_.serial = value;
    } else {
      refuse_option(key, value, "a known key: library, name, serial");
    }
    link_.reset();
  }

  void describe(stillgrid_device_descriptor& descriptor) {
    descriptor.flags = STILLGRID_DEVICE_SETS_PACE;
    descriptor.max_read_ns = 50'000;  // the device itself is served in the vendor's thread
    link().describe(descriptor);
  }

  void identify(stillgrid_device_identity& identity) {
    copy_text(identity.serial, link().serial);
    copy_text(identity.firmware, link().firmware);
    copy_text(identity.driver,
              "stillgrid openhaptics " STILLGRID_VERSION ", OpenHaptics " + link().version);
  }

  [[nodiscard]] bool list(std::uint32_t index, stillgrid_device_listing& listing) {
    link_.reset();  // or it would be busy by us
    return list_openhaptics(choice_.library, index, listing);
  }

  void set_tick(HostTick tick) { tick_ = tick; }

  void activate() {
    if (loop_.clock == STILLGRID_CLOCK_VIRTUAL)
      throw std::runtime_error("a real device has no virtual time: expected no lockstep");
    is_stopped_ = false;
    const OpenHapticsLink& device = link();
    const std::string to_do = device.calibrate(false);
    if (!to_do.empty()) loop_.log.warn("'" + device.model + "' is " + to_do);
    set_rate(device.hd);
    servo_.emplace(device.hd, device.device, tick_, is_stopped_);
    try {
      servo_->start();
    } catch (...) {
      servo_.reset();
      throw;
    }
  }

  std::int32_t read(std::uint64_t now_ns, bool /*is_stopped*/,
                    stillgrid_device_state& state) noexcept {
    return servo_->read(now_ns, state);
  }

  std::int32_t write(std::uint64_t now_ns, bool is_stopped, const double* force_N,
                     const double* /*torque_N_m*/) noexcept {
    static constexpr std::array<double, 3> kZero{};
    const bool is_bad =
        !std::isfinite(force_N[0]) || !std::isfinite(force_N[1]) || !std::isfinite(force_N[2]);
    servo_->write(now_ns, is_bad || is_stopped ? kZero.data() : force_N);
    return is_bad ? STILLGRID_DEVICE_E_ARGUMENT : STILLGRID_DEVICE_OK;
  }

  void command(std::string_view key, std::string_view value) {
    if (key != "calibrate" || value != "1") refuse_option(key, value, "calibrate=1");
    const std::string to_do = link().calibrate(true);
    if (!to_do.empty()) throw DriverError(STILLGRID_DEVICE_E_IO, to_do);
  }

  /// The frame under way may still send what it had: the next one sends zero.
  void emergency_stop() noexcept { is_stopped_ = true; }

  void deactivate() noexcept { servo_->stop(); }

  [[nodiscard]] const char* fault_line(std::int32_t code) noexcept {
    if (code != STILLGRID_DEVICE_E_IO || !servo_ || servo_->fault() == nullptr) return nullptr;
    const unsigned error = servo_->error();
    std::snprintf(line_.data(), line_.size(), "%s%s%s", servo_->fault(),
                  error == kHdSuccess ? "" : ": ",
                  error == kHdSuccess ? "" : link_->hd.get_error_string(error));
    return line_.data();
  }

 private:
  OpenHapticsLink& link() {
    if (link_) return *link_;
    link_.emplace(choice_);
    stillgrid_device_descriptor told{};
    link_->describe(told);
    if (told.max_force_N == 0.0)
      loop_.log.warn("no limits of '" + link_->model +
                     "' are known: limit its force by --max-force");
    return *link_;
  }

  void set_rate(const OpenHapticsLibrary& hd) const {
    const std::uint64_t rate_Hz = (1'000'000'000 + loop_.period_ns / 2) / loop_.period_ns;
    hd.set_scheduler_rate(rate_Hz);
    const unsigned error = hd.take_error().code;
    if (error != kHdSuccess)
      throw DriverError(STILLGRID_DEVICE_E_ARGUMENT, "the vendor's scheduler refuses " +
                                                         std::to_string(rate_Hz) +
                                                         " Hz: " + hd.get_error_string(error));
  }

  HostLoop loop_;
  OpenHapticsChoice choice_;
  HostTick tick_;
  std::atomic<bool> is_stopped_ = false;
  std::optional<OpenHapticsLink> link_;
  std::optional<OpenHapticsServo> servo_;  // after the link: it goes first
  std::array<char, 512> line_{};
};

}  // namespace
}  // namespace stillgrid::devices

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  using stillgrid::devices::OpenHapticsDriver;
  return stillgrid::devices::PluginAdapter<OpenHapticsDriver>::negotiate(host, out);
}
