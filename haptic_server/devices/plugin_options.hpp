#pragma once

#include <charconv>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "haptic_server/devices/trajectory_curve.hpp"
#include "shared/files/number_text.hpp"
#include "shared/tables/trajectory.hpp"

namespace stillgrid::devices {

/// Throws the one line that an option's bad value deserves.
[[noreturn]] inline void refuse_option(std::string_view key, std::string_view value,
                                       const std::string& expected) {
  throw std::runtime_error(std::string(key) + ": value '" + std::string(value) + "': expected " +
                           expected);
}

enum class Bounds { kFinite, kNotNegative, kPositive };

/// The number of an option, in the unit of its key. Throws as refuse_option().
[[nodiscard]] inline double number_option(std::string_view key, std::string_view value,
                                          Bounds bounds) {
  const auto number = files::finite_number(value);
  if (!number) refuse_option(key, value, "a finite number");
  if (bounds == Bounds::kPositive && *number <= 0.0) refuse_option(key, value, "more than 0");
  if (bounds == Bounds::kNotNegative && *number < 0.0) refuse_option(key, value, "0 or more");
  return *number;
}

/// A whole number from 0 to max. Throws as refuse_option().
[[nodiscard]] inline std::uint64_t count_option(std::string_view key, std::string_view value,
                                                std::uint64_t max) {
  std::uint64_t count = 0;
  const char* const end = value.data() + value.size();
  const auto [stop, error] = std::from_chars(value.data(), end, count);
  if (error != std::errc{} || stop != end || count > max) {
    refuse_option(key, value, "a whole number from 0 to " + std::to_string(max));
  }
  return count;
}

/// How a recording is read and evaluated.
struct RecordingOptions {
  tables::TrajectoryOptions trajectory;
  Resampling resampling = Resampling::kLinear;
  double knot_spacing_s = 0.0;  // see make_curve()
};

/// Sets scale, offset_x_m (y, z), map, resample or knot_spacing_s; false for any other key.
/// Throws as refuse_option().
[[nodiscard]] inline bool set_recording_option(RecordingOptions& options, std::string_view key,
                                               std::string_view value) {
  tables::TrajectoryOptions& trajectory = options.trajectory;
  if (key == "scale") {
    trajectory.scale = number_option(key, value, Bounds::kFinite);
  } else if (key == "offset_x_m") {
    trajectory.offset_m.x() = number_option(key, value, Bounds::kFinite);
  } else if (key == "offset_y_m") {
    trajectory.offset_m.y() = number_option(key, value, Bounds::kFinite);
  } else if (key == "offset_z_m") {
    trajectory.offset_m.z() = number_option(key, value, Bounds::kFinite);
  } else if (key == "map") {
    trajectory.map = tables::parse_axis_map(value);
  } else if (key == "knot_spacing_s") {
    options.knot_spacing_s = number_option(key, value, Bounds::kNotNegative);
  } else if (key == "resample") {
    if (value == "linear") {
      options.resampling = Resampling::kLinear;
    } else if (value == "cubic") {
      options.resampling = Resampling::kCubic;
    } else if (value == "band_limited") {
      options.resampling = Resampling::kBandLimited;
    } else {
      refuse_option(key, value, "linear, cubic or band_limited");
    }
  } else {
    return false;
  }
  return true;
}

/// A recording as the options want it evaluated, for a loop of that tick.
[[nodiscard]] inline TrajectoryCurve curve_of(const tables::Trajectory& recording,
                                              const RecordingOptions& options, double tick_s) {
  return make_curve(recording, options.resampling, options.knot_spacing_s, tick_s);
}

}  // namespace stillgrid::devices
