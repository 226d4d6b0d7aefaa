#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "haptic_server/devices/plugin_options.hpp"
#include "haptic_server/devices/plugin_support.hpp"
#include "haptic_server/devices/spacemouse_client.hpp"
#include "haptic_server/devices/spacemouse_motion.hpp"

namespace stillgrid::devices {
namespace {

/// A 3D mouse for people at a desk: its cap steers the tool. It has no motors, so that forces are
/// accepted and felt by nobody.
class SpacemouseDriver {
 public:
  static constexpr const char* kName = "spacemouse";

  explicit SpacemouseDriver(const HostLoop& loop) : clock_(loop.clock), log_(loop.log) {}

  void configure(std::string_view key, std::string_view value) {
    if (key == "speed_m_s") {
      settings_.speed_m_s = number_option(key, value, Bounds::kNotNegative);
    } else if (key == "rotation_rad_s") {
      settings_.rotation_rad_s = number_option(key, value, Bounds::kNotNegative);
    } else if (key == "dead_zone") {
      settings_.dead_zone = number_option(key, value, Bounds::kNotNegative);
      if (settings_.dead_zone >= 1.0) refuse_option(key, value, "less than 1");
    } else if (key == "full_scale") {
      settings_.full_scale = number_option(key, value, Bounds::kPositive);
    } else if (key == "range_m") {
      settings_.range_m = number_option(key, value, Bounds::kPositive);
    } else if (key == "start_x_m") {
      settings_.start_m.x() = number_option(key, value, Bounds::kFinite);
    } else if (key == "start_y_m") {
      settings_.start_m.y() = number_option(key, value, Bounds::kFinite);
    } else if (key == "start_z_m") {
      settings_.start_m.z() = number_option(key, value, Bounds::kFinite);
    } else {
      refuse_option(key, value,
                    "a known key: speed_m_s, rotation_rad_s, dead_zone, full_scale, range_m, "
                    "start_x_m, start_y_m, start_z_m");
    }
  }

  /// No force limit, as there are no motors, and no workspace: range_m is no edge of hardware.
  static void describe(stillgrid_device_descriptor& descriptor) noexcept {
    descriptor.flags = STILLGRID_DEVICE_NO_MOTORS;
    descriptor.max_read_ns = 20'000;
  }

  static void identify(stillgrid_device_identity& identity) noexcept {
    std::strncpy(identity.driver, "stillgrid spacemouse " STILLGRID_VERSION,
                 sizeof identity.driver - 1);
  }

  void activate() {
    if (clock_ == STILLGRID_CLOCK_VIRTUAL)
      throw std::runtime_error("a real mouse has no virtual time: expected no lockstep");
    client_.emplace(log_);
    pose_ = {};
    pose_.position_m = settings_.start_m.cwiseMax(-settings_.range_m).cwiseMin(settings_.range_m);
    last_ns_.reset();
    sequence_ = 0;
  }

  std::int32_t read(std::uint64_t now_ns, bool is_stopped, stillgrid_device_state& state) noexcept {
    const bool is_connected = client_->is_connected();
    state.buttons = client_->buttons();  // first: a press is seen with the motion before it
    const CapCounts counts = client_->counts();
    constexpr std::uint64_t kLongestStep_ns = 50'000'000;  // after a stall the tool does not leap
    const std::uint64_t step_ns = last_ns_ && now_ns > *last_ns_ ? now_ns - *last_ns_ : 0;
    last_ns_ = now_ns;
    if (!is_stopped) {
      steer(pose_, counts, settings_,
            1e-9 * static_cast<double>(std::min(step_ns, kLongestStep_ns)));
    }
    state.valid = STILLGRID_STATE_POSITION | STILLGRID_STATE_ORIENTATION | STILLGRID_STATE_BUTTONS;
    state.time_ns = now_ns;
    state.sequence = ++sequence_;
    Eigen::Map<Eigen::Vector3d>(state.position_m) = pose_.position_m;
    Eigen::Map<Eigen::Vector4d>(state.orientation_xyzw) = pose_.orientation.coeffs();
    return is_connected ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_IO;
  }

  static std::int32_t write(std::uint64_t /*now_ns*/, bool /*is_stopped*/,
                            const double* /*force_N*/, const double* /*torque_N_m*/) noexcept {
    return STILLGRID_DEVICE_OK;
  }

  void deactivate() noexcept { client_.reset(); }

 private:
  std::uint32_t clock_;
  HostLog log_;
  SpacemouseSettings settings_;
  std::optional<SpacemouseClient> client_;
  SteeredPose pose_;
  std::optional<std::uint64_t> last_ns_;
  std::uint64_t sequence_ = 0;
};

}  // namespace
}  // namespace stillgrid::devices

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  return stillgrid::devices::PluginAdapter<stillgrid::devices::SpacemouseDriver>::negotiate(host,
                                                                                            out);
}
