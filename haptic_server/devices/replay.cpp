#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "haptic_server/devices/plugin_options.hpp"
#include "haptic_server/devices/plugin_support.hpp"
#include "haptic_server/devices/trajectory.hpp"
#include "haptic_server/devices/trajectory_curve.hpp"

namespace stillgrid {
namespace {

/// Replays a recorded trajectory; forces are accepted and felt by nobody.
class ReplayDriver {
 public:
  static constexpr const char* kName = "replay";

  explicit ReplayDriver(const HostLoop& /*loop*/) {}

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

  void describe(stillgrid_device_descriptor& descriptor) {
    load();
    Eigen::Map<Eigen::Vector3d> min_m(descriptor.workspace_min_m);
    Eigen::Map<Eigen::Vector3d> max_m(descriptor.workspace_max_m);
    min_m = curve_.knot_position_m.front();
    max_m = min_m;
    for (const Eigen::Vector3d& position_m : curve_.knot_position_m) {
      min_m = min_m.cwiseMin(position_m);
      max_m = max_m.cwiseMax(position_m);
    }
    descriptor.max_read_ns = 20'000;
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
    const bool has_ended = elapsed_ns > duration_ns_;
    if (has_ended)
      elapsed_ns = loops_ && duration_ns_ > 0 ? elapsed_ns % duration_ns_ : duration_ns_;

    const double time_s = static_cast<double>(elapsed_ns) * 1e-9;
    state.valid = STILLGRID_STATE_POSITION;
    state.time_ns = now_ns;
    state.sequence = ++sequence_;
    Eigen::Map<Eigen::Vector3d>(state.position_m) = curve_at(curve_, time_s, cursor_).position_m;
    if (!curve_.orientation.empty()) {
      state.valid |= STILLGRID_STATE_ORIENTATION;
      Eigen::Map<Eigen::Vector4d>(state.orientation_xyzw) =
          orientation_at(curve_, time_s, cursor_).coeffs();
    }
    return has_ended && !loops_ ? STILLGRID_DEVICE_END : STILLGRID_DEVICE_OK;
  }

  static std::int32_t write(std::uint64_t /*now_ns*/, bool /*is_stopped*/,
                            const double* /*force_N*/) noexcept {
    return STILLGRID_DEVICE_OK;
  }

  void deactivate() noexcept {}

 private:
  void load() {
    if (is_loaded_) return;
    if (file_.empty()) refuse_option("file", "", "a trajectory CSV: file=PATH is required");
    const Trajectory trajectory = read_trajectory(file_, options_.trajectory);
    curve_ = make_curve(trajectory, options_.resampling, options_.knot_spacing_s);
    constexpr double kLongest_s = 1e9;  // keeps nanoseconds in range
    duration_ns_ = static_cast<std::uint64_t>(
        std::llround(std::min(trajectory.time_s.back(), kLongest_s) * 1e9));
    is_loaded_ = true;
  }

  std::string file_;
  RecordingOptions options_;
  bool loops_ = false;

  bool is_loaded_ = false;
  TrajectoryCurve curve_;
  std::uint64_t duration_ns_ = 0;

  bool has_started_ = false;
  std::uint64_t start_ns_ = 0;
  std::uint64_t sequence_ = 0;
  CurveCursor cursor_;
};

}  // namespace
}  // namespace stillgrid

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  return stillgrid::PluginAdapter<stillgrid::ReplayDriver>::negotiate(host, out);
}
