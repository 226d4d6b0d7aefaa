#include "sim_server/spheres/ball_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillgrid::spheres {
namespace {

/// Calls visit(cell index) for each cell that comes within reach of a ball.
template <class Visit>
void for_each_cell(const BallGrid& grid, const Ball& ball, double search_radius_m, Visit&& visit) {
  const double radius_m = ball.radius_m + search_radius_m;
  const Eigen::Array3d place_m = ball.centre_m - grid.low_m;
  const auto cell_of = [&](const Eigen::Array3d& at_m) {
    return (at_m / grid.cell_m).floor().cast<int>().max(0).min(grid.cells.array() - 1).eval();
  };
  const Eigen::Array3i low = cell_of(place_m - radius_m), high = cell_of(place_m + radius_m);
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) {
        const Eigen::Array3d corner_m = grid.cell_m * Eigen::Array3d(x, y, z);
        const Eigen::Array3d nearest_m = place_m.max(corner_m).min(corner_m + grid.cell_m);
        if ((nearest_m - place_m).matrix().norm() <= radius_m)
          visit(static_cast<std::size_t>(x + grid.cells.x() * (y + grid.cells.y() * z)));
      }
}

/// Cells large enough that there are not many more of them than balls.
void lay_out(BallGrid& grid, std::span<const Ball> balls, double search_radius_m) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Eigen::Array3d low_m = Eigen::Array3d::Constant(kInfinity), high_m = -low_m;
  for (const Ball& ball : balls) {
    low_m = low_m.min(ball.centre_m.array() - ball.radius_m - search_radius_m);
    high_m = high_m.max(ball.centre_m.array() + ball.radius_m + search_radius_m);
  }
  const Eigen::Array3d size_m = (high_m - low_m).max(1e-12);
  const double wanted = std::clamp(8.0 * static_cast<double>(balls.size()), 512.0, 262144.0);
  // No thinner than the body is thick, or a flat body's cells would be many along its width.
  grid.cell_m = std::max(std::cbrt(size_m.prod() / wanted), size_m.maxCoeff() / 256.0);
  grid.low_m = low_m.matrix();
  grid.cells = ((size_m / grid.cell_m).floor().cast<int>() + 1).matrix();
}

}  // namespace

BallGrid make_ball_grid(std::span<const Ball> balls, double search_radius_m) {
  BallGrid grid;
  if (balls.empty()) return grid;
  lay_out(grid, balls, search_radius_m);
  const auto cell_count = static_cast<std::size_t>(grid.cells.prod());
  grid.starts.assign(cell_count + 1, 0);
  for (const Ball& ball : balls)
    for_each_cell(grid, ball, search_radius_m, [&](std::size_t cell) { ++grid.starts[cell + 1]; });
  for (std::size_t cell = 0; cell < cell_count; ++cell) grid.starts[cell + 1] += grid.starts[cell];
  grid.entries.resize(grid.starts.back());
  std::vector<std::uint32_t> next(grid.starts.begin(), grid.starts.end() - 1);
  for (std::uint32_t i = 0; i < balls.size(); ++i)
    for_each_cell(grid, balls[i], search_radius_m,
                  [&](std::size_t cell) { grid.entries[next[cell]++] = i; });
  return grid;
}

std::span<const std::uint32_t> balls_near(const BallGrid& grid,
                                          const Eigen::Vector3d& point_m) noexcept {
  const Eigen::Array3d place = (point_m - grid.low_m).array() / grid.cell_m;
  if (!(place >= 0.0).all() || !(place < grid.cells.cast<double>().array()).all()) return {};
  const Eigen::Vector3i cell = place.cast<int>();
  const auto index =
      static_cast<std::size_t>(cell.x() + grid.cells.x() * (cell.y() + grid.cells.y() * cell.z()));
  return std::span(grid.entries)
      .subspan(grid.starts[index], grid.starts[index + 1] - grid.starts[index]);
}

}  // namespace stillgrid::spheres
