#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "haptic_server/devices/plugin_options.hpp"
#include "haptic_server/devices/plugin_support.hpp"
#include "haptic_server/devices/trajectory_curve.hpp"
#include "haptic_server/devices/trajectory_faults.hpp"

namespace stillgrid::devices {
namespace {

/// How long a hand takes from the recording's end back to its start: at most 0.2 m/s and 2 rad/s,
/// and 0.1 s at least, for a jump is no motion of a hand. Zero where both are one.
double return_s(const TrajectoryCurve& curve) {
  constexpr double kSpeed_m_s = 0.2;
  constexpr double kRate_rad_s = 2.0;
  constexpr double kShortest_s = 0.1;
  const double way_m = (curve.knot_position_m.back() - curve.knot_position_m.front()).norm();
  const double turn_rad = curve.orientation.empty()
                              ? 0.0
                              : curve.orientation.back().angularDistance(curve.orientation.front());
  if (way_m == 0.0 && turn_rad == 0.0) return 0.0;
  constexpr double kPeak = 1.5;  // of the speed over its mean, see way_back()
  return std::max({kPeak * way_m / kSpeed_m_s, kPeak * turn_rad / kRate_rad_s, kShortest_s});
}

std::uint64_t nanoseconds(double time_s) {
  return static_cast<std::uint64_t>(std::llround(time_s * 1e9));
}

/// Replays a recorded trajectory; forces are accepted and felt by nobody.
class ReplayDriver {
 public:
  static constexpr const char* kName = "replay";

  explicit ReplayDriver(const HostLoop& loop)
      : log_(loop.log), tick_s_(static_cast<double>(loop.period_ns) * 1e-9) {}

  void configure(std::string_view key, std::string_view value) {
    is_loaded_ = false;
    if (set_recording_option(options_, key, value)) return;
    if (key == "file") {
      if (value.empty()) refuse_option(key, value, "a trajectory CSV");
      file_ = value;
    } else if (key == "loop") {
      loops_ = count_option(key, value, 1) == 1;
    } else {
      refuse_option(key, value,
                    "a known key: file, scale, offset_x_m, offset_y_m, offset_z_m, map, resample, "
                    "knot_spacing_s, loop");
    }
  }

  /// No workspace: where the recording goes is not an edge of hardware.
  void describe(stillgrid_device_descriptor& descriptor) {
    load();
    descriptor.flags = STILLGRID_DEVICE_NO_MOTORS;
    descriptor.max_read_ns = 20'000;
  }

  void identify(stillgrid_device_identity& identity) const {
    const std::string name = std::filesystem::path(file_).filename();
    std::strncpy(identity.serial, name.c_str(), sizeof identity.serial - 1);
    std::strncpy(identity.driver, "stillgrid replay " STILLGRID_VERSION,
                 sizeof identity.driver - 1);
  }

  void activate() {
    load();
    has_started_ = false;
    sequence_ = 0;
    cursor_ = {};
  }

  std::int32_t read(std::uint64_t now_ns, bool /*is_stopped*/,
                    stillgrid_device_state& state) noexcept {
    if (!has_started_) start_ns_ = now_ns;
    has_started_ = true;
    std::uint64_t elapsed_ns = now_ns > start_ns_ ? now_ns - start_ns_ : 0;
    const bool loops = loops_ && duration_ns_ > 0;
    if (loops && elapsed_ns > duration_ns_) elapsed_ns %= duration_ns_ + return_ns_;

    state.valid = STILLGRID_STATE_POSITION;
    state.time_ns = now_ns;
    state.sequence = ++sequence_;
    const double time_s = static_cast<double>(elapsed_ns) * 1e-9;
    const double back = way_back(elapsed_ns);
    Eigen::Map<Eigen::Vector3d> position_m(state.position_m);
    position_m = curve_at(curve_, time_s, cursor_).position_m;
    if (back > 0.0) position_m += back * (curve_.knot_position_m.front() - position_m);
    if (!curve_.orientation.empty()) {
      state.valid |= STILLGRID_STATE_ORIENTATION;
      Eigen::Quaterniond turned = orientation_at(curve_, time_s, cursor_);
      if (back > 0.0) turned = turned.slerp(back, curve_.orientation.front()).normalized();
      Eigen::Map<Eigen::Vector4d>(state.orientation_xyzw) = turned.coeffs();
    }
    return elapsed_ns > duration_ns_ && !loops ? STILLGRID_DEVICE_END : STILLGRID_DEVICE_OK;
  }

  static std::int32_t write(std::uint64_t /*now_ns*/, bool /*is_stopped*/,
                            const double* /*force_N*/, const double* /*torque_N_m*/) noexcept {
    return STILLGRID_DEVICE_OK;
  }

  void deactivate() noexcept {}

 private:
  /// How far a looping replay is on its way from the recording's end back to its start, 0 to 1,
  /// at rest at both.
  [[nodiscard]] double way_back(std::uint64_t elapsed_ns) const noexcept {
    if (!loops_ || elapsed_ns <= duration_ns_ || return_ns_ == 0) return 0.0;
    const double share =
        static_cast<double>(elapsed_ns - duration_ns_) / static_cast<double>(return_ns_);
    return share * share * (3.0 - 2.0 * share);
  }

  void load() {
    if (is_loaded_) return;
    if (file_.empty()) refuse_option("file", "", "a trajectory CSV: file=PATH is required");
    const tables::Trajectory recording = tables::read_trajectory(file_, options_.trajectory);
    if (const std::string line = faults_of(file_, recording); !line.empty()) log_.warn(line);
    curve_ = curve_of(recording, options_, tick_s_);
    constexpr double kLongest_s = 1e9;  // keeps nanoseconds in range
    duration_ns_ = nanoseconds(std::min(curve_.knot_time_s.back(), kLongest_s));
    return_ns_ = nanoseconds(std::min(return_s(curve_), kLongest_s));
    is_loaded_ = true;
  }

  HostLog log_;
  double tick_s_;
  std::string file_;
  RecordingOptions options_;
  bool loops_ = false;

  bool is_loaded_ = false;
  TrajectoryCurve curve_;
  std::uint64_t duration_ns_ = 0;
  std::uint64_t return_ns_ = 0;  // of a loop, after the recording

  bool has_started_ = false;
  std::uint64_t start_ns_ = 0;
  std::uint64_t sequence_ = 0;
  CurveCursor cursor_;
};

}  // namespace
}  // namespace stillgrid::devices

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  return stillgrid::devices::PluginAdapter<stillgrid::devices::ReplayDriver>::negotiate(host, out);
}
