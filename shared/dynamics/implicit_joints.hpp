#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/implicit_coupling.hpp"

namespace stillgrid::dynamics {

/// One coupling for each joint without a rest length, in the order of the Description.
[[nodiscard]] std::vector<Coupling> joint_couplings(const Description& description);

/// Makes the couplings of bodies that sleep inactive, and all others active.
void leave_out_joints(std::span<const std::uint8_t> sleeping_nodes,
                      std::span<const std::uint8_t> sleeping_rigid_bodies,
                      std::vector<Coupling>& couplings);

/// Computes impulses and slopes of joint_couplings() for a step that ends at these poses.
/// Realtime: never allocates, locks or throws.
void evaluate_joints(const Description& description, const ImplicitPoses& poses,
                     const Motions& velocities, std::vector<Coupling>& couplings);

/// Returns the losses by dampers of joints in the step that evaluate_joints() computed.
[[nodiscard]] double joint_damping_J(const Description& description, const ImplicitPoses& poses,
                                     const Motions& velocities,
                                     const std::vector<Coupling>& couplings);

}  // namespace stillgrid::dynamics
