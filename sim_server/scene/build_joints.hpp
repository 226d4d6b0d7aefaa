#pragma once

#include <span>

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::scene {

/// Appends the joints of bodies, which are all there in their order, one a point. An end on a
/// deformable body is its node nearest to the point, and there the other end is too, unless it is a
/// node as well. Joined bodies do not collide unless the description says so.
void build_joints(std::span<const JointDescription> joints, bodies::World& world);

}  // namespace stillgrid::scene
