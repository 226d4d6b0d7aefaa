#pragma once

#include <string>

#include "sim_server/dynamics/choice/method_choice.hpp"
#include "sim_server/rate_choice.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// In words that the chosen method misses scene.error_target_m, or that nobody can tell; empty: it
/// keeps it.
[[nodiscard]] std::string target_complaint(const dynamics::MethodChoice& choice,
                                           const scene::SceneDescription& scene);

/// Prints a table: the scene's load, cost and error of each method, the method chosen, and why each
/// other one was not.
[[nodiscard]] std::string explain(const dynamics::MethodChoice& choice,
                                  const scene::SceneDescription& scene);

/// In words that the chosen rate misses a just noticeable difference or scene.processor_share, or
/// that nobody can tell; empty: it keeps both.
[[nodiscard]] std::string force_complaint(const RateChoice& choice,
                                          const scene::SceneDescription& scene);

/// A table for people: of each rate what the simulation would cost and by how much the force on the
/// scene's hand would err. Pre: scene.hand.
[[nodiscard]] std::string explain(const RateChoice& choice, const scene::SceneDescription& scene);

/// A table for people for each body whose contact was chosen: of each model its error, its cost and
/// what it takes. Empty: none was.
[[nodiscard]] std::string explain_contacts(const scene::SceneDescription& scene);

}  // namespace stillgrid::sim_server
