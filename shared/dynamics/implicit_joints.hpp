#pragma once

#include <vector>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/implicit_coupling.hpp"

namespace stillgrid::dynamics {

/// One coupling for each joint without a rest length, in the order of the Description.
[[nodiscard]] std::vector<Coupling> joint_couplings(const Description& description);

/// Computes impulses and slopes of joint_couplings() for a step that ends at these poses.
/// Realtime: never allocates, locks or throws.
void evaluate_joints(const Description& description, const ImplicitPoses& poses,
                     const Motions& velocities, std::vector<Coupling>& couplings);

/// Returns what dampers of joints take in the step that evaluate_joints() computed.
[[nodiscard]] double joint_damping_J(const Description& description, const ImplicitPoses& poses,
                                     const Motions& velocities,
                                     const std::vector<Coupling>& couplings);

}  // namespace stillgrid::dynamics
