#pragma once

#include <span>

#include "sim_server/spheres/ball.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {

/// How stiff a body of balls feels for each N/m of one contact's stiffness: the slope of the normal
/// force against the press depth, mean over the surface; dimensionless.
///
/// Each contact adds its share, so it grows with the number of balls (docs/algorithms/
/// force_criterion.md). A tool sphere of tool_radius_m is pressed press_depth_m deep along each
/// sample's normal.
/// Pre: surface not empty, tool_radius_m >= 0, press_depth_m > 0.
[[nodiscard]] double effective_stiffness(std::span<const Ball> balls, const SurfaceSamples& surface,
                                         double tool_radius_m, double press_depth_m);

/// Returns the factor from a material's stiffness to the stiffness of one contact: 1 /
/// effective_stiffness(). At this depth the slope of the body's force is then the material's
/// stiffness, for any number of balls. The force is about half of stiffness times depth, because it
/// grows with the square of the depth.
///
/// Throws std::runtime_error where the balls do not push back: pressed less deep than the balls lie
/// below the surface. Pre: as effective_stiffness().
[[nodiscard]] double stiffness_scale(std::span<const Ball> balls, const SurfaceSamples& surface,
                                     double tool_radius_m, double press_depth_m);

}  // namespace stillgrid::spheres
