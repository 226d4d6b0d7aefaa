#pragma once

namespace stillgrid::safety {

/// What the motors bear: more than their continuous force, or torque, only for as long as their
/// heat allows. All figures in N, or all in N m.
///
/// Heat follows the square of the force through the motor's thermal time constant. Up to four
/// fifths of what the continuous force makes, the device's own limit holds; from there the limit
/// falls linearly and is the continuous force where that heat is reached. So no force, for however
/// long, is warmer than the continuous one. Thread: the haptic loop's.
/// Realtime: yes.
class ForceBudget {
 public:
  /// continuous: infinite for no budget; else > 0. time_constant_s: > 0.
  ForceBudget(double continuous, double time_constant_s)
      : continuous_(continuous), time_constant_s_(time_constant_s) {}

  /// The most that may be told now. max: the device's own limit.
  [[nodiscard]] double limit(double max) const noexcept;

  /// Books what was held for that long.
  void spend(double held, double elapsed_s) noexcept;

 private:
  double continuous_, time_constant_s_;
  double heat_ = 0.0;  // filtered square of what was held
};

}  // namespace stillgrid::safety
