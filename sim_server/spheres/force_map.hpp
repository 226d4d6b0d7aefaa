#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "sim_server/spheres/ball_grid.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {

/// Balls with the grid that finds those that a tool sphere touches. Body's own frame.
struct BallBody {
  std::vector<Ball> balls;
  BallGrid grid;  // of these balls, with the tool's radius as its reach
  double tool_radius_m = 0.0;
};

[[nodiscard]] BallBody make_ball_body(std::span<const Ball> balls, double tool_radius_m);

/// The force on the body's tool sphere, still, for a contact stiffness of 1 N/m: the contact law
/// summed over the balls that it touches. In N for each N/m, that is in metres.
/// Realtime: balls_near(), then once per ball near; never allocates, locks or throws.
[[nodiscard]] Eigen::Vector3d unit_force_m(const BallBody& body,
                                           const Eigen::Vector3d& tool_m) noexcept;

/// The force on a tool sphere, for 1 N/m, by the place of its centre.
using UnitForce = std::function<Eigen::Vector3d(const Eigen::Vector3d& tool_m)>;

/// What a tool feels that is pressed equally deep all over a surface. Forces for 1 N/m, in metres.
/// A perfect body of 1 N/m: mean = press depth, stiffness 1, all else 0 but min_over_max = 1.
struct ForceMap {
  double mean_m = 0.0;               // normal force
  double ripple = 0.0;               // its standard deviation over its mean
  double min_over_max = 0.0;         // of the normal force; below 0 where it pulls in
  double peak_to_peak = 0.0;         // over its mean
  double hole_share = 0.0;           // of samples with less than kHoleFraction of the median
  double reversed_share = 0.0;       // of samples where the tool is pulled in
  double tangential = 0.0;           // mean of the sideways force, over the mean normal force
  double effective_stiffness = 0.0;  // slope of the mean normal force against the depth
};

/// A sample whose normal force is less than this share of the median is a hole.
inline constexpr double kHoleFraction = 0.1;

/// The criterion on forces, not on geometry [Davanne 2002, Fig. 5]: the tool's sphere is pressed
/// press_depth_m deep along the normal of each sample. The slope is the central difference over a
/// thousandth of the depth. Without force anywhere all but the holes is zero.
/// Pre: surface not empty, press_depth_m > 0.
[[nodiscard]] ForceMap map_force(const SurfaceSamples& surface, double tool_radius_m,
                                 double press_depth_m, const UnitForce& force);

}  // namespace stillgrid::spheres
