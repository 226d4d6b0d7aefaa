#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "sim_server/fields/measured_surface.hpp"
#include "sim_server/spheres/ball.hpp"
#include "sim_server/spheres/ball_grid.hpp"

namespace stillgrid::fields {

/// Most places of one map.
inline constexpr std::size_t kMaxStiffnessPlaces = 100'000;

/// Reads a table (shared/tables) with the columns x_m, y_m, z_m and stiffness_N_per_m, a row a
/// place. Throws std::runtime_error naming file, line, column and value for stiffnesses outside of
/// 1e-9 to 1e12 N/m, for a file without a place, or with too many.
[[nodiscard]] std::vector<StiffnessPlace> read_stiffness_places(const std::filesystem::path& file);

/// A stiffness over space from places where it is known: smooth, positive, between the least and
/// the most that goes in.
///
/// Each place counts by (1 - distance^2 / width^2)^3 within its width, 1.75 times the mean distance
/// to the three places nearest to it; beside them all the body's own stiffness counts by
/// kOwnWeight, so that beyond the widths of all places the map is just that. Twice continuously
/// differentiable [Shepard 1968; Franke and Nielson 1980]. One place alone: its stiffness
/// everywhere.
class StiffnessMap {
 public:
  static constexpr double kWidth = 1.75;
  static constexpr double kOwnWeight = 0.02;

  /// Pre: at most kMaxStiffnessPlaces, all finite, stiffnesses > 0. Places may repeat.
  StiffnessMap(std::span<const StiffnessPlace> places, double own_N_per_m);

  /// Pre: finite.
  [[nodiscard]] double stiffness_N_per_m(const Eigen::Vector3d& point_m) const;

 private:
  std::vector<StiffnessPlace> places_;
  std::vector<spheres::Ball> balls_;  // a place and its width; none if it alone is everywhere
  spheres::BallGrid grid_;
  double own_N_per_m_;
};

}  // namespace stillgrid::fields
