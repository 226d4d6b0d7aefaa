#pragma once

namespace stillgrid::safety {

/// What the motors bear: more than their continuous force only for as long as their heat allows.
///
/// Heat follows the square of the force through the motor's thermal time constant. Up to four
/// fifths of what the continuous force makes, the device's own limit holds; from there the limit
/// falls linearly and is the continuous force where that heat is reached. So no force, for however
/// long, is warmer than the continuous one. Torque is not counted. Thread: the haptic loop's.
/// Realtime: yes.
class ForceBudget {
 public:
  /// continuous_N: infinite for no budget; else > 0. time_constant_s: > 0.
  ForceBudget(double continuous_N, double time_constant_s)
      : continuous_N_(continuous_N), time_constant_s_(time_constant_s) {}

  /// The most that may be told now, N. max_force_N: the device's own limit.
  [[nodiscard]] double limit_N(double max_force_N) const noexcept;

  /// Books a force that was held for that long.
  void spend(double force_N, double elapsed_s) noexcept;

 private:
  double continuous_N_, time_constant_s_;
  double heat_N2_ = 0.0;  // filtered square of the force
};

}  // namespace stillgrid::safety
