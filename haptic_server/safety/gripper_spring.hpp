#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

namespace stillgrid::safety {

/// What drives a gripper's fingers apart; each is none at zero.
struct GripperLimits {
  double stiffness_N_per_m = 0.0;
  double open_m = 0.0;  // where the spring is slack: the widest opening
  double max_force_N = 0.0;
};

/// A spring between the fingers of a gripper. Its force grows by at most a tenth of the limit in a
/// millisecond, from zero after any gap; it falls at once. Thread: the haptic loop's. Realtime:
/// yes.
class GripperSpring {
 public:
  explicit GripperSpring(const GripperLimits& limits) : limits_(limits) {}

  /// The force on the fingers, N, positive opens. gripper_m: the opening, nothing where it is not
  /// told. may_push: the device takes a force and is believed. elapsed_s: since the tick before;
  /// from stall_s on the force begins anew.
  [[nodiscard]] double apply(std::optional<double> gripper_m, bool may_push, double elapsed_s,
                             double stall_s) noexcept {
    constexpr double kGrowth_per_s = 100.0;  // of the limit
    const bool is_there = gripper_m && may_push && elapsed_s < stall_s &&
                          std::abs(*gripper_m - 0.5 * limits_.open_m) <= limits_.open_m;
    const double wished_N =
        is_there ? limits_.stiffness_N_per_m * (limits_.open_m - *gripper_m) : 0.0;
    const double most_N = held_N_ + kGrowth_per_s * limits_.max_force_N * elapsed_s;
    return held_N_ =
               std::clamp(wished_N, 0.0, std::max(0.0, std::min(most_N, limits_.max_force_N)));
  }

 private:
  GripperLimits limits_;
  double held_N_ = 0.0;
};

}  // namespace stillgrid::safety
