#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace stillgrid {

/// Why the force told to the device is not the rendered one, or what else was odd in a tick.
enum SafetyFlag : std::uint32_t {
  kFlagBadDevice = 1U << 0U,  // the device gave no position or no number
  kFlagRejected = 1U << 1U,   // the rendered force was no number
  kFlagFaded = 1U << 2U,      // stale image, or ramp after one
  kFlagClamped = 1U << 3U,    // above the device's limit
  kFlagSlewed = 1U << 4U,     // changed faster than --max-slew
  kFlagContended = 1U << 5U,  // no fresh read in this tick
  kFlagCut = 1U << 6U,        // more in reach than a tick may look at
  kFlagSwept = 1U << 7U,      // a contact that was only on the way to this tick
  kFlagPassivity = 1U << 8U,  // damped by --passivity-control
};
inline constexpr std::array<std::string_view, 9> kSafetyFlagNames = {
    "bad_device", "rejected", "faded", "clamped",  "slewed",
    "contended",  "cut",      "swept", "passivity"};

/// A force and its moment about the tool's origin.
struct Wrench {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();
};

struct GuardLimits {
  double max_force_N = 0.0;                 // finite, > 0: norm of the force
  std::optional<double> max_slew_N_per_ms;  // finite, > 0; none: not limited
};

/// How fresh the image is that a force was rendered from.
struct ImageFreshness {
  bool exists = false;
  double image_age_s = 0.0;  // since its publication
  double period_s = 0.0;     // declared by the simulation
  bool writer_alive = false;
};

/// The last stage before the device: no number, stale data, too much force, too sudden a change.
///
/// No driver declares a limit for torque: it is limited, and its change too, to what the force's
/// limit makes at the end of the tool's lever. Force and torque are shortened by one factor and
/// faded alike; either that is no number takes both. Fade: begins when no image came for 1.5
/// declared periods, at once when the simulation is known dead, and ends 100 ms later at zero; the
/// force comes back as slowly, also at the start. Thread: the haptic loop's. Realtime: yes.
class ForceGuard {
 public:
  explicit ForceGuard(const GuardLimits& limits) : limits_(limits) {}

  /// What the device is told, from what was rendered; sets the flags of what intervened.
  /// lever_m: of the tool's point that is farthest from its origin, > 0.
  [[nodiscard]] Wrench apply(const Wrench& rendered, double lever_m,
                             const ImageFreshness& freshness, double tick_s,
                             std::uint32_t& flags) noexcept;

  /// Whether a fade is over: a change of scene cannot be felt now. Realtime: yes.
  [[nodiscard]] bool is_silent() const noexcept { return gain_ == 0.0; }

 private:
  GuardLimits limits_;
  double gain_ = 0.0;
  Wrench last_;  // before the fade
};

}  // namespace stillgrid
