#pragma once

#include "tests/laws/random.hpp"
#include "tests/laws/scene_text.hpp"

namespace stillgrid::laws {

/// Joins some of a scene's free rigid bodies to each other, between their centres, and if they may
/// be hung some to the world, above them. Leaves a scene as it is that has none of the kind.
void draw_joints(SceneText& scene, Random& random, bool may_be_hung);

}  // namespace stillgrid::laws
