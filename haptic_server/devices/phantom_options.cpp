#include "haptic_server/devices/phantom_options.hpp"

#include <algorithm>
#include <limits>
#include <sstream>

#include "haptic_server/devices/phantom_instrument.hpp"

namespace stillgrid::devices {
namespace {

/// A numeric option, and the setting it takes the place of.
struct NumberOption {
  std::string_view key;
  Bounds bounds;
  double& (*place)(PhantomSettings&);
};

constexpr double kMaxHold_s = 1e6;
constexpr std::array<std::string_view, 3> kPivotKeys = {"pivot_x_m", "pivot_y_m", "pivot_z_m"};

using Settings = PhantomSettings;
constexpr std::array kNumberOptions = {
    NumberOption{"mass_kg", Bounds::kPositive,
                 [](Settings& s) -> double& { return s.device.mass_kg; }},
    NumberOption{"damping_N_s_per_m", Bounds::kNotNegative,
                 [](Settings& s) -> double& { return s.device.damping_N_s_per_m; }},
    NumberOption{"friction_N", Bounds::kNotNegative,
                 [](Settings& s) -> double& { return s.device.friction_N; }},
    NumberOption{"resolution_m", Bounds::kNotNegative,
                 [](Settings& s) -> double& { return s.device.resolution_m; }},
    NumberOption{"max_force_N", Bounds::kNotNegative,
                 [](Settings& s) -> double& { return s.device.max_force_N; }},
    NumberOption{"hand_mass_kg", Bounds::kNotNegative,
                 [](Settings& s) -> double& { return s.hand.mass_kg; }},
    NumberOption{"hand_damping_N_s_per_m", Bounds::kNotNegative,
                 [](Settings& s) -> double& { return s.hand.damping_N_s_per_m; }},
    NumberOption{"hand_stiffness_N_per_m", Bounds::kNotNegative,
                 [](Settings& s) -> double& { return s.hand.stiffness_N_per_m; }},
    NumberOption{"noise_m", Bounds::kNotNegative, [](Settings& s) -> double& { return s.noise_m; }},
    NumberOption{"push_x_N", Bounds::kFinite, [](Settings& s) -> double& { return s.push_N.x(); }},
    NumberOption{"push_y_N", Bounds::kFinite, [](Settings& s) -> double& { return s.push_N.y(); }},
    NumberOption{"push_z_N", Bounds::kFinite, [](Settings& s) -> double& { return s.push_N.z(); }},
    NumberOption{"start_x_m", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.start_m.x(); }},
    NumberOption{"start_y_m", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.start_m.y(); }},
    NumberOption{"start_z_m", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.start_m.z(); }},
    NumberOption{"velocity_x_m_s", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.start_velocity_m_s.x(); }},
    NumberOption{"velocity_y_m_s", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.start_velocity_m_s.y(); }},
    NumberOption{"velocity_z_m_s", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.start_velocity_m_s.z(); }},
    NumberOption{"centre_x_m", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.path.centre_m.x(); }},
    NumberOption{"centre_y_m", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.path.centre_m.y(); }},
    NumberOption{"centre_z_m", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.path.centre_m.z(); }},
    NumberOption{"depth_m", Bounds::kFinite, [](Settings& s) -> double& { return s.path.depth_m; }},
    NumberOption{"amplitude_m", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.path.amplitude_m; }},
    NumberOption{"period_s", Bounds::kPositive,
                 [](Settings& s) -> double& { return s.path.period_s; }},
    NumberOption{"gripper_m", Bounds::kNotNegative,
                 [](Settings& s) -> double& { return s.gripper.open_m; }},
    NumberOption{"grip_N", Bounds::kFinite,
                 [](Settings& s) -> double& { return s.gripper.grip_N; }},
};

std::string known_keys() {
  std::string keys = "a known key: profile, hand, path, pace, delay_ticks, seed, limits, hold_s";
  for (const NumberOption& option : kNumberOptions) keys += ", " + std::string(option.key);
  for (const std::string_view key : kPivotKeys) keys += ", " + std::string(key);
  return keys + ", scale, offset_x_m, offset_y_m, offset_z_m, map, resample, knot_spacing_s";
}

auto place_of(std::string_view key) {
  return std::find_if(kNumberOptions.begin(), kNumberOptions.end(),
                      [key](const NumberOption& option) { return option.key == key; })
      ->place;
}

std::optional<Pace> pace_named(std::string_view name) noexcept {
  if (name == "host") return Pace::kHost;
  if (name == "device") return Pace::kDevice;
  if (name == "late") return Pace::kLate;
  return std::nullopt;
}

std::string text_of(const Eigen::Vector3d& point_m) {
  std::ostringstream text;
  text << point_m.x() << ' ' << point_m.y() << ' ' << point_m.z();
  return text.str();
}

void check_pivot(const PhantomSettings& settings, const Eigen::Vector3d& pivot_m) {
  std::optional<Eigen::Vector3d> unfit_m = unfit_point_m(settings.path, pivot_m);
  if (!unfit_m && !holds_instrument(settings.start_m, pivot_m)) unfit_m = settings.start_m;
  if (!unfit_m) return;
  refuse_option("pivot_x_m, pivot_y_m, pivot_z_m", text_of(pivot_m),
                "a point below the handle's path and start and 0.02 m from them, not one by " +
                    text_of(*unfit_m));
}

}  // namespace

void PhantomOptions::set(std::string_view key, std::string_view value) {
  if (set_recording_option(recording_, key, value)) return;
  const auto* const number =
      std::find_if(kNumberOptions.begin(), kNumberOptions.end(),
                   [key](const NumberOption& option) { return option.key == key; });
  if (number != kNumberOptions.end()) {
    numbers_.emplace_back(std::string(key), number_option(key, value, number->bounds));
  } else if (const auto pivot = std::find(kPivotKeys.begin(), kPivotKeys.end(), key);
             pivot != kPivotKeys.end()) {
    pivot_m_[static_cast<std::size_t>(pivot - kPivotKeys.begin())] =
        number_option(key, value, Bounds::kFinite);
  } else if (key == "profile") {
    const auto profile = phantom_profile(value);
    if (!profile) refuse_option(key, value, "touch, touchx or premium15");
    profile_ = *profile;
  } else if (key == "hand") {
    const auto hand = hand_profile(value);
    if (!hand) refuse_option(key, value, "none, light or measured");
    hand_ = *hand;
  } else if (key == "path") {
    if (!path_kind(value) && !value.ends_with(".csv")) {
      refuse_option(key, value, "still, press, stroke, tap, circle or a trajectory FILE.csv");
    }
    path_ = value;
  } else if (key == "pace") {
    const auto pace = pace_named(value);
    if (!pace) refuse_option(key, value, "host, device or late");
    pace_ = *pace;
  } else if (key == "delay_ticks") {
    delay_ticks_ = static_cast<int>(count_option(key, value, kMaxDelayTicks));
  } else if (key == "seed") {
    seed_ = count_option(key, value, std::numeric_limits<std::uint64_t>::max());
  } else if (key == "hold_s") {
    hold_ns_ = static_cast<std::uint64_t>(
        1e9 * std::min(number_option(key, value, Bounds::kNotNegative), kMaxHold_s));
  } else if (key == "limits") {
    declares_limits_ = count_option(key, value, 1) == 1;
  } else {
    refuse_option(key, value, known_keys());
  }
}

PhantomSettings PhantomOptions::settings() const {
  PhantomSettings settings;
  settings.device = profile_;
  settings.hand = hand_;
  settings.delay_ticks = delay_ticks_;
  settings.seed = seed_;
  settings.tick_s = static_cast<double>(period_ns_) * 1e-9;
  if (const auto kind = path_kind(path_)) {
    settings.path.kind = *kind;
  } else {
    settings.path.kind = PathKind::kRecorded;
    settings.path.recorded = curve_of(tables::read_trajectory(path_, recording_.trajectory),
                                      recording_, settings.tick_s);
  }
  const auto apply_overrides = [&] {
    for (const auto& [key, value] : numbers_) place_of(key)(settings) = value;
  };
  apply_overrides();
  settings.start_m = path_at(settings.path, 0.0).position_m;
  apply_overrides();  // again, for a start that is not the path's
  if (const auto at_m = pivot()) check_pivot(settings, *at_m);
  return settings;
}

std::optional<Eigen::Vector3d> PhantomOptions::pivot() const {
  const auto given = std::find_if(pivot_m_.begin(), pivot_m_.end(),
                                  [](const auto& number) { return number.has_value(); });
  if (given == pivot_m_.end()) return std::nullopt;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!pivot_m_[axis])
      refuse_option(kPivotKeys[axis], "", "a number, for all three of a pivot or none");
  return Eigen::Vector3d(*pivot_m_[0], *pivot_m_[1], *pivot_m_[2]);
}

}  // namespace stillgrid::devices
