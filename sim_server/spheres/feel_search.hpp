#pragma once

#include <functional>
#include <vector>

#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/felt_error.hpp"
#include "sim_server/spheres/press.hpp"

namespace stillgrid::spheres {

/// Spheres of one fineness, and how they feel.
struct FeltLevel {
  std::vector<Ball> balls;
  FeltError error;          // over places that they were not fitted to
  bool is_even = false;     // else thinned
  double fineness_m = 0.0;  // tolerance, or spacing of even ones, that they were made with
};

/// Told of each level when it is done.
using FeltLevelDone = std::function<void(const FeltLevel&)>;

/// Most spheres of the last level, if nothing else is said.
inline constexpr std::size_t kMaxFeltBalls = 20000;

/// Looks for the fewest spheres whose force is within `share` of the mesh's, from coarse to fine:
/// thinned ones first, then firm even ones, each level moved by fit_force(). The last level is the
/// first that is near enough, or the finest of at most most_balls. Takes seconds to
/// minutes. Throws as decompose(); StopRequested. Pre: closed, as make_closed() leaves it; press of
/// it; share > 0, most_balls > 0.
[[nodiscard]] std::vector<FeltLevel> search_by_feel(const mesh::TriangleMesh& closed,
                                                    const Press& press, double share,
                                                    const FeltLevelDone& on_level = {},
                                                    std::size_t most_balls = kMaxFeltBalls);

/// The level to take: the last where it is near enough, else the nearest.
[[nodiscard]] const FeltLevel& best_of(const std::vector<FeltLevel>& levels, double share);

}  // namespace stillgrid::spheres
