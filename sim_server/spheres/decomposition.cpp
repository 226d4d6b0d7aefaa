#include "sim_server/spheres/decomposition.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/spheres/decomposition_candidates.hpp"
#include "sim_server/spheres/decomposition_cover.hpp"
#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {
namespace {

// Shares of the tolerance.
constexpr double kGrown = 0.95;      // a ball sticks out so far
constexpr double kCovered = 0.96;    // what covers must hold to; the rest is for between samples
constexpr double kInside = 0.02;     // what lies deep is covered by so much
constexpr double kSlack = 0.1;       // of a medial ball
constexpr double kSpacing = 0.15;    // of the patches that are looked at between rounds
constexpr double kSmall = 0.5;       // of a ball where the inside is in doubt
constexpr double kPrecision = 0.02;  // of the final bounds

constexpr std::size_t kMaxCandidates = 8000, kMaxPlaces = 12'000, kLeastSamples = 3000,
                      kMaxSamples = 40'000;
constexpr double kMaxHeld = 1e7;  // pairs of a candidate and a sample
constexpr std::uint64_t kFirstVisits = 60'000'000, kMoreVisits = 15'000'000;  // of a search
constexpr int kSearchedRounds = 16, kMaxRounds = 60;
// Comparisons, about; some ten to the nine take a second.
constexpr std::uint64_t kMaxWork = 30'000'000'000, kWorkOfPatch = 1000;

/// A point that a ball must come to within search_radius_m of, and a ball inside the solid that
/// does.
struct Demand {
  Eigen::Vector3d point_m;
  double search_radius_m;
  Eigen::Vector3d sample_m, normal;  // of the surface above it; the normal is zero deep inside
};

/// The cover in the making: demands are elements, candidates are sets.
class Covering {
 public:
  Covering(const MeshSolid& solid, double tolerance_m) : solid_(solid), tolerance_m_(tolerance_m) {}

  /// A ball inside the solid, to be grown.
  void add_candidate(const Ball& inscribed) {
    add_ball({inscribed.centre_m, inscribed.radius_m + kGrown * tolerance_m_}, inscribed.radius_m);
  }

  /// The surface near a sample: a ball must cover what lies below it at the tolerance's depth or,
  /// where the solid is too thin for that, come near the sample itself.
  void demand_surface(const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal) {
    const double depth_m = kCovered * tolerance_m_;
    const Eigen::Vector3d below_m = point_m - depth_m * normal;
    const bool is_thick = solid_.distance.signed_distance_m(below_m) < -0.999 * depth_m;
    add_demand(is_thick ? Demand{below_m, 0.0, point_m, normal}
                        : Demand{point_m, depth_m, point_m, normal});
  }

  void demand_inside(const Eigen::Vector3d& point_m) {
    add_demand({point_m, -kInside * tolerance_m_, point_m, Eigen::Vector3d::Zero()});
  }

  /// Shrinks the balls that bury a point of the mesh until they touch it, or are inside the solid.
  void keep_clear(const std::vector<Eigen::Vector3d>& points_m) {
    std::vector<std::uint32_t> orphans;
    const std::size_t before = balls_.size();
    for (std::size_t i = 0; i < before; ++i) {
      const Ball ball = balls_[i];
      double radius_m = ball.radius_m;
      work_ += points_m.size();
      for (const Eigen::Vector3d& point_m : points_m)
        radius_m = std::min(radius_m, (point_m - ball.centre_m).norm());
      radius_m = std::max(radius_m, inscribed_m_[i]);
      if (radius_m >= ball.radius_m) continue;
      for (const std::uint32_t demand : cover_.forbid(static_cast<std::uint32_t>(i)))
        orphans.push_back(demand);
      balls_[i].radius_m = 0.0;
      add_ball({ball.centre_m, radius_m}, inscribed_m_[i]);
    }
    for (const std::uint32_t demand : orphans) {
      const Ball own = own_ball(demands_[demand]);
      if (holds(own, demands_[demand])) add_ball(own, own.radius_m);
      // Where a mesh cuts itself no ball inside may meet it; the error that is measured will tell.
      cover_.forget_lost(demand);
    }
  }

  void solve(std::uint64_t visits) {
    work_ += visits;
    cover_.cover_greedily();
    cover_.improve(visits);
  }

  /// Comparisons so far bound the time, on no clock; once they are spent no demand is taken.
  void spend(std::uint64_t comparisons) { work_ += comparisons; }
  [[nodiscard]] bool is_spent() const { return work_ >= kMaxWork; }

  [[nodiscard]] std::vector<Ball> balls() const {
    std::vector<Ball> chosen;
    for (const std::uint32_t set : cover_.chosen()) chosen.push_back(balls_[set]);
    return chosen;
  }

 private:
  [[nodiscard]] static bool holds(const Ball& ball, const Demand& demand) {
    const double search_radius_m = std::max(0.0, ball.radius_m + demand.search_radius_m);
    return (ball.centre_m - demand.point_m).squaredNorm() <= search_radius_m * search_radius_m;
  }
  /// A ball that meets the demand: one inside the solid or, where a mesh cuts itself and its inside
  /// is in doubt, a small one about the surface; of no radius where neither does.
  [[nodiscard]] Ball own_ball(const Demand& demand) const {
    if (demand.normal.isZero(0.0))
      return {demand.point_m, -solid_.distance.signed_distance_m(demand.point_m)};
    const Ball inside = medial_ball(solid_, demand.sample_m, demand.normal, kSlack * tolerance_m_);
    if (inside.radius_m > 0.0 && holds(inside, demand)) return inside;
    return {demand.point_m, kSmall * tolerance_m_};
  }
  void add_ball(const Ball& ball, double inscribed_m) {
    work_ += demands_.size();
    if (!(ball.radius_m > 0.0)) return;  // a place outside the solid has no ball
    realtime::throw_if_stopped();
    std::vector<std::uint32_t> held;
    for (std::size_t i = 0; i < demands_.size(); ++i)
      if (holds(ball, demands_[i])) held.push_back(static_cast<std::uint32_t>(i));
    cover_.add_set(std::move(held));
    balls_.push_back(ball);
    inscribed_m_.push_back(inscribed_m);
  }
  void add_demand(const Demand& demand) {
    if (is_spent()) return;
    const auto sets = [&] {
      work_ += balls_.size();
      std::vector<std::uint32_t> found;
      for (std::size_t i = 0; i < balls_.size(); ++i)
        if (holds(balls_[i], demand)) found.push_back(static_cast<std::uint32_t>(i));
      return found;
    };
    if (!cover_.add_element(sets())) {
      const Ball own = own_ball(demand);
      add_ball(own, own.radius_m);
      if (!cover_.add_element(sets())) return;  // a fold of the mesh: no ball inside it is near
    }
    demands_.push_back(demand);
  }

  const MeshSolid& solid_;
  double tolerance_m_;
  std::vector<Ball> balls_;
  std::vector<double> inscribed_m_;  // a ball's radius before it grew
  std::vector<Demand> demands_;
  SetCover cover_;
  std::uint64_t work_ = 0;
};

void check_tolerance(double tolerance_m, double size_m) {
  constexpr double kFinest = 1.0 / 5000.0;
  if (tolerance_m >= kFinest * size_m && std::isfinite(tolerance_m)) return;
  std::ostringstream text;
  text << "tolerance: value " << tolerance_m
       << " m: expected at least 1/5000 of the box's diagonal, " << kFinest * size_m << " m";
  throw std::invalid_argument(text.str());
}

/// Which of these points are the first in their cell of a lattice.
std::vector<std::size_t> one_a_cell(const std::vector<Eigen::Vector3d>& points_m, double cell_m) {
  std::set<std::array<double, 3>> taken;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const Eigen::Array3d cell = (points_m[i] / cell_m).array().floor();
    if (taken.insert({cell[0], cell[1], cell[2]}).second) kept.push_back(i);
  }
  return kept;
}

/// The mean share of the samples that a grown candidate holds.
double share_held(const std::vector<Ball>& candidates, const SurfaceSamples& samples,
                  double grown_m) {
  constexpr std::size_t kProbes = 200;
  std::size_t held = 0, asked = 0;
  for (std::size_t i = 0; i < samples.points_m.size(); i += samples.points_m.size() / kProbes + 1) {
    asked += candidates.size();
    for (const Ball& ball : candidates)
      held += (ball.centre_m - samples.points_m[i]).norm() < ball.radius_m + grown_m ? 1U : 0U;
  }
  return asked > 0 ? static_cast<double>(held) / static_cast<double>(asked) : 0.0;
}

Covering first_demands(const MeshSolid& solid, double tolerance_m) {
  Covering covering(solid, tolerance_m);
  const double wanted = mesh::surface_area_m2(solid.mesh) / (tolerance_m * tolerance_m);
  auto count = static_cast<std::size_t>(
      std::clamp(wanted, static_cast<double>(kLeastSamples), static_cast<double>(kMaxSamples)));
  SurfaceSamples samples = sample_surface(solid.mesh, count);
  const auto candidates_of = [&](std::size_t most) {
    const SurfaceSamples places =
        sample_surface(solid.mesh, std::min(samples.points_m.size(), kMaxPlaces));
    return medial_balls(solid, places, kSlack * tolerance_m, 0.5 * tolerance_m, most);
  };
  std::vector<Ball> candidates = candidates_of(kMaxCandidates);
  // Where balls hold much each, as in a body that is nearly a ball, fewer of both will do.
  const double held = share_held(candidates, samples, kGrown * tolerance_m) *
                      static_cast<double>(candidates.size()) * static_cast<double>(count);
  if (held > kMaxHeld) {
    const double kept = std::sqrt(kMaxHeld / held);
    count = static_cast<std::size_t>(kept * static_cast<double>(count)) + 1;
    samples = sample_surface(solid.mesh, count);
    candidates =
        candidates_of(static_cast<std::size_t>(kept * static_cast<double>(candidates.size())) + 1);
  }
  for (const Ball& ball : candidates) covering.add_candidate(ball);
  for (std::size_t i = 0; i < samples.points_m.size(); ++i)
    covering.demand_surface(samples.points_m[i], samples.normals[i]);
  // What lies deepest is covered too, or the union would be hollow.
  for (const Ball& ball : candidates)
    if (ball.radius_m > tolerance_m) covering.demand_inside(ball.centre_m);
  return covering;
}

}  // namespace

Decomposition decompose(const mesh::TriangleMesh& closed, double tolerance_m,
                        const DecompositionProgress& progress) {
  const auto tell = [&](const char* step, double done) {
    if (progress) progress(step, done);
  };
  const MeshSolid solid(closed);
  check_tolerance(tolerance_m, solid.size_m);
  tell("medial balls", 0.0);
  Covering covering = first_demands(solid, tolerance_m);
  Decomposition best;
  double spacing_m = kSpacing * tolerance_m;
  for (int round = 0; round < kMaxRounds && !covering.is_spent(); ++round) {
    const bool is_searched = round < kSearchedRounds;
    if (!is_searched && !best.balls.empty()) return best;
    tell("fewest spheres", is_searched ? static_cast<double>(round) / kSearchedRounds : 1.0);
    covering.solve(round == 0 ? kFirstVisits : is_searched ? kMoreVisits : 0);
    const std::vector<Ball> balls = covering.balls();
    if (!best.balls.empty() && balls.size() >= best.balls.size()) return best;
    const TooFar far = find_too_far(solid, balls, (1.0 - kPrecision) * tolerance_m, spacing_m);
    covering.spend(kWorkOfPatch * far.patches);
    if (far.none()) {
      Decomposition result = with_error(solid, balls, kPrecision * tolerance_m);
      result.tolerance_m = tolerance_m;
      if (result.is_reached()) best = std::move(result);
      if (best.balls.empty()) spacing_m *= 0.5;
    }
    covering.keep_clear(far.filled_m);
    for (const std::size_t i : one_a_cell(far.uncovered.points_m, 2.0 * spacing_m))
      covering.demand_surface(far.uncovered.points_m[i], far.uncovered.normals[i]);
    for (const std::size_t i : one_a_cell(far.hollows_m, 2.0 * spacing_m))
      covering.demand_inside(far.hollows_m[i]);
  }
  if (!best.balls.empty()) return best;
  tell("error", 1.0);
  covering.solve(0);
  Decomposition result = with_error(solid, covering.balls(), kPrecision * tolerance_m);
  result.tolerance_m = tolerance_m;
  return result;
}

}  // namespace stillgrid::spheres
