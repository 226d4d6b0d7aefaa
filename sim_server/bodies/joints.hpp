#pragma once

#include <Eigen/Core>
#include <span>

#include "sim_server/bodies/world.hpp"

namespace stillgrid::bodies {

/// Of what stretches it.
[[nodiscard]] double joint_energy_J(const Joint& joint, std::span<const Node> nodes,
                                    std::span<const RigidBody> rigid_bodies);

}  // namespace stillgrid::bodies
