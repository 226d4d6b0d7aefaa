#pragma once

#include <string>

#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// Memory that a scene takes, or that there is for it.
struct Memory {
  double private_bytes = 0.0;  // of the process
  double shared_bytes = 0.0;   // of what it publishes
};

/// What one body of a scene takes while it is simulated by a method, from counts alone: its nodes,
/// springs, spheres and field. Right to a factor of two for bodies of more than a thousand nodes or
/// spheres.
[[nodiscard]] Memory memory_need(const bodies::BodyDescription& body, const scene::Method& method);

/// Refuses a scene that would take more than there is, before anything of it is built, or that has
/// more than a million spheres. Throws std::runtime_error, one line, at the body that takes most:
/// `FILE:LINE: body 'NAME': memory: value 48.1 GB: expected ...`.
void require_room(const scene::SceneDescription& scene, const std::string& file,
                  const Memory& available);

}  // namespace stillgrid::dynamics
