#pragma once

#include <iosfwd>

#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Judges scene files by the force on the scene's own hand, for scene_fit.
///
/// Each line of `in` names a scene file and a transition, separated by a blank: `half.toml
/// local`. An empty line, or the end, starts the judgement of the lines before it, on all
/// processors. Writes one Record a file as a line of JSON, in their order, with the line as its
/// name. The Record of a file that cannot be read has a refusal. Throws as Judge. Pre: scene.hand.
void try_files(const scene::SceneDescription& scene, std::istream& in, std::ostream& out);

}  // namespace stillgrid::sim_server
