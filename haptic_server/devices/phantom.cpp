#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptic_server/devices/path.hpp"
#include "haptic_server/devices/phantom_instrument.hpp"
#include "haptic_server/devices/phantom_model.hpp"
#include "haptic_server/devices/plugin_options.hpp"
#include "haptic_server/devices/plugin_support.hpp"

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
};

std::string known_keys() {
  std::string keys = "a known key: profile, hand, path, delay_ticks, seed, limits, hold_s";
  for (const NumberOption& option : kNumberOptions) keys += ", " + std::string(option.key);
  for (const std::string_view key : kPivotKeys) keys += ", " + std::string(key);
  return keys + ", scale, offset_x_m, offset_y_m, offset_z_m, map, resample, knot_spacing_s";
}

std::string text_of(const Eigen::Vector3d& point_m) {
  std::ostringstream text;
  text << point_m.x() << ' ' << point_m.y() << ' ' << point_m.z();
  return text.str();
}

/// The simulated device behind the plugin interface. Its time is the host's, from the first
/// read or write after activate().
class PhantomDriver {
 public:
  static constexpr const char* kName = "phantom";

  explicit PhantomDriver(const HostLoop& loop) : period_ns_(loop.period_ns), log_(loop.log) {
    recording_.resampling = Resampling::kCubic;  // a hand's velocity does not step
  }

  void configure(std::string_view given_key, std::string_view value) {
    const std::string_view key = names_.key_of(given_key, value);
    if (key != given_key)
      log_.warn("option " + std::string(given_key) + " is now " + std::string(key));
    if (set_recording_option(recording_, key, value)) return;
    const auto* const number =
        std::find_if(kNumberOptions.begin(), kNumberOptions.end(),
                     [key](const NumberOption& option) { return option.key == key; });
    if (number != kNumberOptions.end()) {
      overrides_.emplace_back(number, number_option(key, value, number->bounds));
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

  void describe(stillgrid_device_descriptor& descriptor) const {
    const PhantomSettings set = settings();
    const PhantomProfile& device = set.device;
    // Of a stylus without motors for torque, which is ignored. With a pivot the trocar bears half
    // of what the handle's force makes on the longest instrument that the workspace holds.
    descriptor.max_torque_N_m = 0.1 * device.max_force_N;
    if (const auto at_m = pivot()) {
      const double longest_m = (set.start_m - *at_m).norm() + 0.5 * device.workspace_m.norm();
      descriptor.max_torque_N_m = 2.0 * device.max_force_N * longest_m;
    }
    descriptor.position_resolution_m = device.resolution_m;
    descriptor.max_force_N = device.max_force_N;
    descriptor.flags = STILLGRID_DEVICE_NO_MOTORS;
    descriptor.max_read_ns = 200'000;
    if (!declares_limits_) return;
    Eigen::Map<Eigen::Vector3d>(descriptor.workspace_min_m) = -0.5 * device.workspace_m;
    Eigen::Map<Eigen::Vector3d>(descriptor.workspace_max_m) = 0.5 * device.workspace_m;
    descriptor.continuous_force_N = device.continuous_force_N;
    descriptor.nominal_stiffness_N_m = device.nominal_stiffness_N_m;
    descriptor.motor_time_constant_s = device.motor_time_constant_s;
    descriptor.max_speed_m_s = device.max_speed_m_s;
  }

  static void identify(stillgrid_device_identity& identity) noexcept {
    std::strncpy(identity.serial, "simulated", sizeof identity.serial - 1);
    std::strncpy(identity.driver, "stillgrid phantom " STILLGRID_VERSION,
                 sizeof identity.driver - 1);
  }

  void activate() {
    model_ = make_phantom(settings());
    pivot_ = pivot();
    if (pivot_) instrument_ = place_instrument({}, model_.position_m, *pivot_);
    has_started_ = false;
    sequence_ = 0;
  }

  std::int32_t read(std::uint64_t now_ns, bool is_stopped, stillgrid_device_state& state) noexcept {
    catch_up(now_ns, is_stopped);
    state.valid = STILLGRID_STATE_POSITION;
    state.time_ns = now_ns;
    state.sequence = ++sequence_;
    const Eigen::Vector3d position_m = read_encoders(model_);
    Eigen::Map<Eigen::Vector3d>(state.position_m) = position_m;
    if (pivot_) {
      instrument_ = place_instrument(instrument_, position_m, *pivot_);
      state.valid |= STILLGRID_STATE_ORIENTATION;
      Eigen::Map<Eigen::Vector4d>(state.orientation_xyzw) = orientation_of(instrument_).coeffs();
    }
    return STILLGRID_DEVICE_OK;
  }

  std::int32_t write(std::uint64_t now_ns, bool is_stopped, const double* force_N,
                     const double* torque_N_m) noexcept {
    catch_up(now_ns, is_stopped);
    Eigen::Vector3d force = Eigen::Map<const Eigen::Vector3d>(force_N);
    if (pivot_ && torque_N_m != nullptr)
      force = force_at_handle_N(instrument_, force, Eigen::Map<const Eigen::Vector3d>(torque_N_m));
    if (!is_stopped) command_force(model_, force);
    return force.allFinite() ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ARGUMENT;
  }

  void deactivate() noexcept { release_force(model_); }

 private:
  /// Everything configured so far, put together.
  [[nodiscard]] PhantomSettings settings() const {
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
      settings.path.recorded = read_curve(path_, recording_, settings.tick_s);
    }
    const auto apply_overrides = [&] {
      for (const auto& [option, value] : overrides_) option->place(settings) = value;
    };
    apply_overrides();
    settings.start_m = path_at(settings.path, 0.0).position_m;
    apply_overrides();  // again, for a start that is not the path's
    if (const auto at_m = pivot()) check_pivot(settings, *at_m);
    return settings;
  }

  /// Throws where only a part of it is given.
  [[nodiscard]] std::optional<Eigen::Vector3d> pivot() const {
    const auto given = std::find_if(pivot_m_.begin(), pivot_m_.end(),
                                    [](const auto& number) { return number.has_value(); });
    if (given == pivot_m_.end()) return std::nullopt;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!pivot_m_[axis])
        refuse_option(kPivotKeys[axis], "", "a number, for all three of a pivot or none");
    return Eigen::Vector3d(*pivot_m_[0], *pivot_m_[1], *pivot_m_[2]);
  }

  static void check_pivot(const PhantomSettings& settings, const Eigen::Vector3d& pivot_m) {
    std::optional<Eigen::Vector3d> unfit_m = unfit_point_m(settings.path, pivot_m);
    if (!unfit_m && !holds_instrument(settings.start_m, pivot_m)) unfit_m = settings.start_m;
    if (!unfit_m) return;
    refuse_option("pivot_x_m, pivot_y_m, pivot_z_m", text_of(pivot_m),
                  "a point below the handle's path and start and 0.02 m from them, not one by " +
                      text_of(*unfit_m));
  }

  /// Moves the model to now_ns, the force held. What a stall takes beyond 50 ticks is skipped,
  /// or catching up would make the next read late in its turn.
  void catch_up(std::uint64_t now_ns, bool is_stopped) noexcept {
    constexpr std::uint64_t kMaxSubsteps = 50 * kSubstepsPerTick;
    if (is_stopped) release_force(model_);
    if (!has_started_) start_ns_ = now_ns;
    has_started_ = true;
    const std::uint64_t free_ns = start_ns_ + hold_ns_;
    const std::uint64_t elapsed_ns = now_ns > free_ns ? now_ns - free_ns : 0;
    const std::uint64_t target = elapsed_ns * kSubstepsPerTick / period_ns_;
    if (target <= model_.substeps_done) return;
    const std::uint64_t due = target - model_.substeps_done;
    if (due > kMaxSubsteps) start_ns_ += (due - kMaxSubsteps) * period_ns_ / kSubstepsPerTick;
    advance_phantom(model_, std::min(due, kMaxSubsteps));
  }

  PhantomProfile profile_ = *phantom_profile("touch");
  HandProfile hand_ = *hand_profile("light");
  std::string path_ = "press";
  RecordingOptions recording_;
  int delay_ticks_ = 0;
  std::uint64_t seed_ = 1;
  bool declares_limits_ = true;
  std::uint64_t hold_ns_ = 0;  // that it stays at its start, whatever pushes
  OptionNames names_;
  std::vector<std::pair<const NumberOption*, double>> overrides_;
  std::array<std::optional<double>, 3> pivot_m_;  // as configured

  std::uint64_t period_ns_;
  HostLog log_;
  PhantomModel model_;
  std::optional<Eigen::Vector3d> pivot_;
  Instrument instrument_;  // as last read
  bool has_started_ = false;
  std::uint64_t start_ns_ = 0;
  std::uint64_t sequence_ = 0;
};

}  // namespace
}  // namespace stillgrid::devices

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  return stillgrid::devices::PluginAdapter<stillgrid::devices::PhantomDriver>::negotiate(host, out);
}
