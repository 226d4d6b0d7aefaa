#pragma once

#include <string>
#include <vector>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/spheres/ball.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {

/// Balls, and what a contact's stiffness is multiplied with where the scene does not normalise it.
struct ScaledBalls {
  std::vector<spheres::Ball> balls;
  double stiffness_scale = 1.0;
};

/// The fewest spheres that feel as near to the mesh as `feel` of the scene's table asks, at the
/// stiffness at which they do. Adds lines to notes. Throws SceneError.
[[nodiscard]] ScaledBalls read_felt_balls(toml::TableReader& spheres, bool is_soft,
                                          const mesh::TriangleMesh& mesh,
                                          const BodyDescription& body,
                                          std::vector<std::string>& notes);

/// A note if spheres thinned to a tolerance feel worse than the mesh's nearest face would.
void note_feel(const std::vector<spheres::Ball>& balls, const mesh::TriangleMesh& mesh,
               double tolerance_m, const BodyDescription& body, std::vector<std::string>& notes);

}  // namespace stillgrid::bodies
