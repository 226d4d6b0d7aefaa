#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/fineness.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {

/// What the force of all levels is measured with.
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

/// A report of sphere_decompose, see docs/formats.md, but for the names of files: what was read,
/// repaired and asked for; count, errors and force of each level; what it took.
[[nodiscard]] nlohmann::json report_fields(const mesh::TriangleMesh& read,
                                           const mesh::ClosedMesh& closed, const Fineness& fineness,
                                           std::span<const Decomposition> levels,
                                           const Press& press, double time_s);

}  // namespace stillgrid::spheres
