#pragma once

#include <span>
#include <vector>

#include "sim_server/spheres/ball.hpp"
#include "sim_server/spheres/felt_error.hpp"

namespace stillgrid::spheres {

/// Moves balls and changes their radii so that the sum of their springs follows the mesh's force.
///
/// Least squares of the differences, in metres, over all centres and radii, by Levenberg and
/// Marquardt's method, whose normal equations are solved by conjugate gradients; the stiffness
/// stays that which suits the balls as they come. No ball grows or moves by more than half of
/// itself in a step. The same input gives the same balls; where nothing pushes back they stay.
/// Pre: balls not empty, exact of a tool of this radius, at least four places a ball.
[[nodiscard]] std::vector<Ball> fit_force(std::span<const Ball> balls, const ExactForces& exact,
                                          double tool_radius_m);

}  // namespace stillgrid::spheres
