#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim_server/spheres/ball.hpp"

namespace stillgrid::spheres {

/// Which balls may reach a point, found by reading one cell of a regular grid. Body's own frame.
///
/// Every ball is entered in each cell that comes within the reach of its surface, so its size and
/// that of the others do not matter. Made once for a rigid body.
struct BallGrid {
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
  double cell_m = 1.0;
  Eigen::Vector3i cells = Eigen::Vector3i::Zero();  // x fastest
  std::vector<std::uint32_t> starts;                // cells + 1, into entries
  std::vector<std::uint32_t> entries;               // balls, ascending in each cell
};

/// The grid of balls for points up to search_radius_m from a ball's surface; about eight cells a
/// ball, from 512 to 262,144. Pre: radii >= 0, search_radius_m >= 0, all finite.
[[nodiscard]] BallGrid make_ball_grid(std::span<const Ball> balls, double search_radius_m);

/// All balls whose surface is within the grid's reach of the point, and some others; none far from
/// all. Realtime: reads one cell; never allocates, locks or throws; NaN meets no ball.
[[nodiscard]] std::span<const std::uint32_t> balls_near(const BallGrid& grid,
                                                        const Eigen::Vector3d& point_m) noexcept;

}  // namespace stillgrid::spheres
