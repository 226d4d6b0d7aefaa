#pragma once

#include <Eigen/Core>

namespace stillgrid::safety {

/// Keeps the stiffness of all contacts together within what a device can render.
///
/// Contacts add up: seven spheres of 500 N/m are a wall of 3,500 N/m, which a held force of that
/// device may make buzz (docs/algorithms/passivity.md). Where the greatest stiffness of the contact
/// matrix exceeds the limit, the force is scaled by their ratio; the scale falls within 10 ms and
/// comes back over 100 ms, so that a contact more is no step; where no force is felt it falls at
/// once, or the first touch would be a pulse. Thread: the haptic loop's. Realtime: yes.
class StiffnessGovernor {
 public:
  /// limit_N_per_m: > 0, infinite for none.
  explicit StiffnessGovernor(double limit_N_per_m) : limit_N_per_m_(limit_N_per_m) {}

  /// The share of the force to keep, in (0, 1]. stiffness_N_per_m: symmetric, the sum over contacts
  /// of k n n^T. is_felt: whether any force is held now. elapsed_s: since the tick before.
  [[nodiscard]] double share(const Eigen::Matrix3d& stiffness_N_per_m, bool is_felt,
                             double elapsed_s) noexcept;

 private:
  double limit_N_per_m_;
  double share_ = 1.0;
};

}  // namespace stillgrid::safety
