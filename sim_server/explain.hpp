#pragma once

#include <string>

#include "sim_server/dynamics/method_choice.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid {

/// A table for people: the scene's load, the method chosen, and of every other one its cost
/// predicted and measured, its error, and why it was refused.
[[nodiscard]] std::string explain(const MethodChoice& choice, const SceneDescription& scene);

}  // namespace stillgrid
