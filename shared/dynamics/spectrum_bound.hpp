#pragma once

#include <vector>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Bounds of vibrations on springs and joints. No vibration is faster, by the Cauchy-Schwarz
/// inequality for each spring between masses m and n:
/// |x - y|^2 <= (1 + m / n) |x|^2 + (1 + n / m) |y|^2.
struct SpectrumBound {
  double stiffness_per_s2 = 0.0;  // square of the fastest undamped vibration
  double damping_per_s = 0.0;     // at which dampers slow the fastest relative motion

  friend SpectrumBound operator+(const SpectrumBound& a, const SpectrumBound& b) {
    return {a.stiffness_per_s2 + b.stiffness_per_s2, a.damping_per_s + b.damping_per_s};
  }
};
/// Bounds springs, however bodies deform.
[[nodiscard]] SpectrumBound spring_bound(const Description& description);

/// Bounds joints, which turn a rigid body more stiffly the farther they are stretched.
class JointBound {
 public:
  explicit JointBound(const Description& description);
  /// Returns the bound for the state and the next within_s. Realtime: yes.
  [[nodiscard]] SpectrumBound operator()(const Description& description, const SceneState& state,
                                         double within_s);

 private:
  std::vector<SpectrumBound> sums_;  // nodes, then rigid bodies; empty without joints
};

/// Returns the number of equal substeps of a tick, for Verlet's method. A substep is half of the
/// longest stable one, h with h^2 stiffness / 4 + h damping / 2 = 1.
[[nodiscard]] int stable_substeps(const SpectrumBound& bound, double tick_s);

}  // namespace stillgrid::dynamics
