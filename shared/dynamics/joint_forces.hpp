#pragma once

#include <Eigen/Core>
#include <span>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/wrench.hpp"

namespace stillgrid::dynamics {

/// Dampers of joints between nodes act along their line. Square of the length from which on a line
/// has a direction.
inline constexpr double kShortestLine_m2 = 1e-10;

/// Adds the forces of joints and their dampers to nodes and rigid bodies, in the order of the
/// state. Both ends are pulled at the place of end a, so that momentum is kept to rounding.
/// Realtime: never allocates, locks or throws.
void add_joint_forces(std::span<const Description::Joint> joints, const SceneState& state,
                      std::span<Vector4> node_forces_N, std::span<Wrench> rigid_wrenches);

}  // namespace stillgrid::dynamics
