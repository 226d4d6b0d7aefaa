#pragma once

#include <span>
#include <string>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/felt_error.hpp"
#include "sim_server/spheres/press.hpp"

namespace stillgrid::spheres {

/// How spheres feel to a tool that is pressed in all over their mesh.
struct Feel {
  FeltError error;  // beside the mesh
  ForceMap map;
};

/// Pre: balls not empty, press of that mesh.
[[nodiscard]] Feel feel_of(std::span<const Ball> balls, const mesh::MeshDistance& mesh,
                           const Press& press);

/// Whether the mesh's nearest face would feel better: spheres that are a just noticeable
/// difference or more from the mesh's force, or have a hole or a place that pulls in. The nearest
/// face, at places that a tool reaches alone, has none of these.
[[nodiscard]] bool is_worse_than_nearest_face(const Feel& feel);

/// Such spheres' fault in words that follow "a tool of R m feels them ".
[[nodiscard]] std::string fault_of(const Feel& feel);

}  // namespace stillgrid::spheres
