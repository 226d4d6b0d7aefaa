#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "haptic_server/devices/mouse_handle.hpp"
#include "haptic_server/devices/phantom_options.hpp"
#include "haptic_server/devices/plugin_options.hpp"
#include "haptic_server/devices/plugin_support.hpp"
#include "shared/publication/mouse_segment.hpp"
#include "shared/publication/segment_watch.hpp"

namespace stillgrid::devices {
namespace {

/// Options that say where the handle goes until a mouse takes it, as those of phantom.
constexpr std::array<std::string_view, 7> kPathKeys = {
    "path", "centre_x_m", "centre_y_m", "centre_z_m", "depth_m", "amplitude_m", "period_s"};

/// The mouse of the viewer's page, by the session's mouse segment. A handle is simulated, for the
/// mouse itself has no motors.
class MouseDriver {
 public:
  static constexpr const char* kName = "mouse";

  explicit MouseDriver(const HostLoop& loop)
      : loop_(loop), session_(loop.session), path_options_(loop.period_ns) {
    path_options_.set("path", "still");
  }

  void configure(std::string_view key, std::string_view value) {
    if (std::find(kPathKeys.begin(), kPathKeys.end(), key) != kPathKeys.end()) {
      path_options_.set(key, value);
    } else if (key == "pull_N") {
      hand_.pull_N = number_option(key, value, Bounds::kPositive);
      if (hand_.pull_N > kStrongest_N) refuse_option(key, value, "8 at most");
    } else if (key == "range_m") {
      hand_.range_m = number_option(key, value, Bounds::kPositive);
      if (hand_.range_m > kFarthest_m) refuse_option(key, value, "5 at most");
    } else if (key == "session") {
      session_ = value;
      static_cast<void>(publication::segment_name(session_, kKind));
    } else {
      std::string known = "a known key: pull_N, range_m, session";
      for (const std::string_view path_key : kPathKeys) known += ", " + std::string(path_key);
      refuse_option(key, value, known);
    }
  }

  void describe(stillgrid_device_descriptor& descriptor) const {
    const PhantomProfile device = settings().device;
    descriptor.flags = STILLGRID_DEVICE_NO_MOTORS;
    descriptor.max_read_ns = 200'000;
    Eigen::Map<Eigen::Vector3d>(descriptor.workspace_min_m) = -0.5 * device.workspace_m;
    Eigen::Map<Eigen::Vector3d>(descriptor.workspace_max_m) = 0.5 * device.workspace_m;
    descriptor.max_force_N = device.max_force_N;
    descriptor.max_torque_N_m = 0.1 * device.max_force_N;  // none is felt
    descriptor.nominal_stiffness_N_per_m = device.nominal_stiffness_N_per_m;
    descriptor.max_speed_m_s = device.max_speed_m_s;
    descriptor.button_count = 2;
    descriptor.dof_actuated = STILLGRID_DOF_X | STILLGRID_DOF_Y | STILLGRID_DOF_Z;
    descriptor.dof_sensed = descriptor.dof_actuated | STILLGRID_DOF_ABOUT_X |
                            STILLGRID_DOF_ABOUT_Y | STILLGRID_DOF_ABOUT_Z;
  }

  static void identify(stillgrid_device_identity& identity) noexcept {
    std::strncpy(identity.driver, "stillgrid mouse " STILLGRID_VERSION, sizeof identity.driver - 1);
  }

  void activate() {
    if (loop_.clock == STILLGRID_CLOCK_VIRTUAL)
      throw std::runtime_error("a real mouse has no virtual time: expected no lockstep");
    if (session_.empty()) throw std::runtime_error("expected session=NAME");
    handle_.emplace(settings(), hand_);
    sequence_ = 0;
    watch_.emplace(session_, kKind, proto::kMouseLayoutHash, proto::Clock::kMonotonic,
                   [log = loop_.log](const std::string& line) { log.warn(line); });
    watch_->start();
  }

  std::int32_t read(std::uint64_t now_ns, bool is_stopped, stillgrid_device_state& state) noexcept {
    if (is_stopped) handle_->release();
    handle_->follow(now_ns, loop_.period_ns, newest_aim());
    state.valid = STILLGRID_STATE_POSITION | STILLGRID_STATE_ORIENTATION | STILLGRID_STATE_BUTTONS;
    state.time_ns = now_ns;
    state.sequence = ++sequence_;
    Eigen::Map<Eigen::Vector3d>(state.position_m) = handle_->position_m();
    Eigen::Map<Eigen::Vector4d>(state.orientation_xyzw) = handle_->orientation().coeffs();
    state.buttons = handle_->buttons();
    state.status_known = STILLGRID_STATUS_ENABLED;
    state.status = handle_->is_held() ? STILLGRID_STATUS_ENABLED : 0U;
    return STILLGRID_DEVICE_OK;
  }

  std::int32_t write(std::uint64_t /*now_ns*/, bool is_stopped, const double* force_N,
                     const double* /*torque_N_m*/) noexcept {
    const Eigen::Vector3d force(force_N);
    if (!is_stopped) handle_->exert(force);
    return force.allFinite() ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ARGUMENT;
  }

  void deactivate() noexcept {
    watch_.reset();
    if (handle_) handle_->release();
  }

 private:
  static constexpr auto kKind = proto::SegmentKind::kMouse;
  static constexpr double kStrongest_N = 8.0, kFarthest_m = 5.0;

  [[nodiscard]] PhantomSettings settings() const {
    const PhantomSettings path = path_options_.settings();
    return mouse_settings(path.path, hand_.range_m, path.tick_s);
  }

  /// That of the page that holds the hand; a viewer that has ended holds it no more.
  [[nodiscard]] std::optional<MouseAim> newest_aim() noexcept {
    const publication::MouseView* const view = watch_->acquire();
    if (view == nullptr || !watch_->writer_alive()) return std::nullopt;
    const auto pose = view->read();
    if (!pose) return std::nullopt;
    return MouseAim{.time_ns = pose->time_ns,
                    .position_m = Eigen::Vector3d(pose->position_m.data()),
                    .orientation = Eigen::Quaterniond(pose->orientation_xyzw.data()).normalized(),
                    .buttons = static_cast<std::uint32_t>(pose->buttons)};
  }

  HostLoop loop_;
  std::string session_;
  PhantomOptions path_options_;
  MouseHand hand_;
  std::optional<MouseHandle> handle_;
  std::uint64_t sequence_ = 0;
  std::optional<publication::SegmentWatch<publication::MouseView>> watch_;
};

}  // namespace
}  // namespace stillgrid::devices

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  return stillgrid::devices::PluginAdapter<stillgrid::devices::MouseDriver>::negotiate(host, out);
}
