#pragma once

#include <Eigen/Geometry>

#include "sim_server/bodies/motion.hpp"
#include "sim_server/fields/measured_surface.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

/// Reads the keys `offset_m` and `stiffness_map` of a mesh's table `field`. Throws SceneError; what
/// is wrong in the map's file is named with its line there. box: the mesh's.
[[nodiscard]] fields::MeasuredSurface read_measured_surface(toml::TableReader& field,
                                                            const Eigen::AlignedBox3d& box_m,
                                                            Motion motion);

}  // namespace stillgrid::bodies
