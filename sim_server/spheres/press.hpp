#pragma once

#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {

/// What the force of a body is measured with.
struct Press {
  SurfaceSamples surface;  // where the tool can be pressed
  double tool_radius_m = 0.0, depth_m = 0.0;
};

/// A tool that is pressed into a mesh; a radius of 0 is 2 % of the box's diagonal, a depth of 0 a
/// quarter of the radius, but no more than tolerance_m unless that is 0. Throws std::runtime_error
/// where the tool fits nowhere.
/// Pre: closed, as make_closed() leaves it; all finite and not negative.
[[nodiscard]] Press make_press(const mesh::TriangleMesh& closed, double tool_radius_m,
                               double press_depth_m, double tolerance_m);

}  // namespace stillgrid::spheres
