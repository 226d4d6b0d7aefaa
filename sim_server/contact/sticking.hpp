#pragma once

#include <Eigen/Core>
#include <cmath>

#include "shared/collision/contact_law.hpp"

namespace stillgrid::contact {

/// What holds points of contact together across the normal.
struct StickingForce {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // at the step's end
  double share = 1.0;  // 1: sticks; less: slides, and the force is that share of what would hold
};
/// A spring of the contact's own stiffness with its own damper, stretched as the points slide by
/// slid_m, and in line with them something that gives way at most_N [Cundall, Strack 1979]. Taken
/// at the step's end, so that it never gives energy: with r what would hold and s the stretch, the
/// loss is h c |ds/h|^2 + k |ds|^2 / 2 + most_N |slip|, and the slip is along r. Pre: both across
/// the normal; step_s > 0.
[[nodiscard]] StickingForce sticking_force(const collision::ContactMaterial& material,
                                           const Eigen::Vector3d& stretch_m,
                                           const Eigen::Vector3d& slid_m, double most_N,
                                           double step_s) noexcept;

/// The stretch that holds at another stiffness the energy that this one holds.
[[nodiscard]] inline Eigen::Vector3d stretched_as(const Eigen::Vector3d& stretch_m,
                                                  double before_N_per_m, double now_N_per_m) {
  if (before_N_per_m == now_N_per_m || !(now_N_per_m > 0.0)) return stretch_m;
  return std::sqrt(before_N_per_m / now_N_per_m) * stretch_m;
}

}  // namespace stillgrid::contact
