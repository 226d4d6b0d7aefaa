#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim_server/spheres/ball.hpp"
#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {

/// The largest ball within a solid that touches its surface at a point: shrunk from one as large as
/// the solid until no other part of the surface is deeper in it than slack_m. Its radius is the
/// true distance from its centre to the surface. [Ma, Bae and Choi, 3D medial point approximation
/// using nearest neighbors and the normal field, The Visual Computer 28, 2012], with nearest points
/// of the mesh instead of samples. Pre: point_m on the surface, normal its outward unit normal,
/// slack_m > 0.
[[nodiscard]] Ball medial_ball(const MeshSolid& solid, const Eigen::Vector3d& point_m,
                               const Eigen::Vector3d& normal, double slack_m);

/// Medial balls of all samples, those that hardly differ once: centres and radii at least
/// spacing_m apart, about, and more where there would be more than `most`. The larger come first.
[[nodiscard]] std::vector<Ball> medial_balls(const MeshSolid& solid, const SurfaceSamples& samples,
                                             double slack_m, double spacing_m, std::size_t most);

}  // namespace stillgrid::spheres
