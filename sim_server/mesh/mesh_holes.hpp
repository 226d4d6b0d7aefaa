#pragma once

#include <Eigen/Core>
#include <span>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// The largest area of holes that are closed, over that of the surface.
inline constexpr double kSmallHoles = 0.01;

struct ClosedHoles {
  int count = 0;
  double longest_border_m = 0.0;
};

/// Closes all holes by faces from their middles, if they are small: one missing triangle each, or
/// together at most kSmallHoles of the surface. Else, or if borders meet, leaves the mesh as it is
/// and returns no holes. `border` holds the ends of each edge of one face, as that face has them.
[[nodiscard]] ClosedHoles close_small_holes(TriangleMesh& mesh,
                                            std::span<const Eigen::Vector2i> border);

}  // namespace stillgrid::mesh
