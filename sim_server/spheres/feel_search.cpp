#include "sim_server/spheres/feel_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/force_fit.hpp"
#include "sim_server/spheres/sampling.hpp"

namespace stillgrid::spheres {
namespace {

// Of the box's diagonal.
constexpr double kTolerances[] = {0.08, 0.04, 0.02, 0.01};
constexpr double kFirstSpacing = 0.04;
const double kNextSpacing = std::pow(2.0, -0.25);  // 1.4 times as many

class FeelSearch {
 public:
  FeelSearch(const mesh::TriangleMesh& closed, const Press& press, double share,
             const FeltLevelDone& on_level, std::size_t most_balls)
      : solid_(closed),
        press_(press),
        share_(share),
        on_level_(on_level),
        most_balls_(most_balls),
        exact_(exact_forces(press.surface, solid_.distance, press.tool_radius_m, press.depth_m)) {}

  std::vector<FeltLevel> run() {
    for (const double tolerance : kTolerances) {
      const double tolerance_m = tolerance * solid_.size_m;
      std::vector<Ball> thinned = decompose(solid_.mesh, tolerance_m).balls;
      if (!levels_.empty() && thinned.size() > most_balls_) return levels_;
      if (add(std::move(thinned), false, tolerance_m)) return levels_;
    }
    for (double spacing_m = kFirstSpacing * solid_.size_m;; spacing_m *= kNextSpacing) {
      realtime::throw_if_stopped();
      if (expected(spacing_m) > static_cast<double>(most_balls_)) return levels_;
      std::vector<Ball> even = firm_surface_balls_if_any(solid_.mesh, spacing_m);
      if (even.empty() || even.size() <= levels_.back().balls.size()) continue;
      if (even.size() > most_balls_ || add(std::move(even), true, spacing_m)) return levels_;
    }
  }

 private:
  /// At least so many lie that far apart under the surface: a guess that only bounds the work.
  [[nodiscard]] double expected(double spacing_m) const {
    return 0.2 * mesh::surface_area_m2(solid_.mesh) / (spacing_m * spacing_m);
  }

  /// Fits them and adds them; whether they are near enough.
  bool add(std::vector<Ball> balls, bool is_even, double fineness_m) {
    constexpr std::size_t kPlacesABall = 5, kLeastPlaces = 1000;
    const ExactForces exact =
        press_everywhere(solid_.mesh, solid_.distance, kLeastPlaces + kPlacesABall * balls.size(),
                         press_.tool_radius_m, std::array{press_.depth_m});
    if (!exact.tool_m.empty()) balls = fit_force(balls, exact, press_.tool_radius_m);
    const BallBody body = make_ball_body(balls, press_.tool_radius_m);
    const FeltError error = felt_error(
        exact_, [&](const Eigen::Vector3d& tool_m) { return unit_force_m(body, tool_m); });
    levels_.push_back({std::move(balls), error, is_even, fineness_m});
    if (on_level_) on_level_(levels_.back());
    return error.share <= share_;
  }

  MeshSolid solid_;
  const Press& press_;
  double share_;
  const FeltLevelDone& on_level_;
  std::size_t most_balls_;
  ExactForces exact_;
  std::vector<FeltLevel> levels_;
};

}  // namespace

std::vector<FeltLevel> search_by_feel(const mesh::TriangleMesh& closed, const Press& press,
                                      double share, const FeltLevelDone& on_level,
                                      std::size_t most_balls) {
  return FeelSearch(closed, press, share, on_level, most_balls).run();
}

const FeltLevel& best_of(const std::vector<FeltLevel>& levels, double share) {
  if (levels.back().error.share <= share) return levels.back();
  return *std::min_element(
      levels.begin(), levels.end(),
      [](const FeltLevel& a, const FeltLevel& b) { return a.error.share < b.error.share; });
}

}  // namespace stillgrid::spheres
