// The solution of an island's contacts in a substep.

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim_server/dynamics/contacts/contact_core.hpp"

namespace stillgrid::dynamics {
namespace {

/// Of the bound of a body's ratio, its part that is found in practice: for Chebyshev's weights,
/// which converge also if it was too little.
constexpr double kTypicalBound = 0.5;
/// Of that, what is counted on after iterations overshot.
constexpr double kCareful = 0.25;
/// What rounding leaves, of the largest change of velocity, and where nothing moves.
constexpr double kRounding = 1e-11, kRounding_m_s = 1e-14;
/// Touches of an island that is solved in less time than a deadline is worth looking at, and the
/// iterations between two looks in a larger one.
constexpr std::size_t kLargeIsland = 4096;
constexpr int kIterationsALook = 8;

/// Chebyshev's weights for eigenvalues between 1 / (1 + ratio) and 1, iteration by iteration.
class ChebyshevWeights {
 public:
  ChebyshevWeights() = default;
  explicit ChebyshevWeights(double ratio) : ratio_(ratio) {
    const double least = 1.0 / (1.0 + ratio);
    middle_ = 0.5 * (1.0 + least);
    half_ = 0.5 * (1.0 - least);
    weight_ = half_ / middle_;
  }
  [[nodiscard]] double ratio() const { return ratio_; }
  [[nodiscard]] double first() const { return 1.0 / middle_; }
  struct Next {
    double momentum, residual;
  };
  [[nodiscard]] Next next() {
    if (!(half_ > 0.0)) return {0.0, 1.0};
    const double next = 1.0 / (2.0 * middle_ / half_ - weight_);
    return {next * std::exchange(weight_, next), 2.0 * next / half_};
  }

 private:
  double ratio_ = 0.0, middle_ = 1.0, half_ = 0.0, weight_ = 0.0;
};

}  // namespace

std::span<ContactRows> ContactCore::rows_of(const ContactIsland& island) {
  return std::span(rows_).subspan(island.rows.first, island.rows.last - island.rows.first);
}

/// Impulses of all contacts at the velocities of the island's points; whether they may change by no
/// more than the responses count on.
bool ContactCore::evaluate(const ContactIsland& island, double substep_s) {
  const bool is_bounded = evaluate_rows(rows_of(island), movers_.velocities(),
                                        movers_.clear_impulses(island), substep_s);
  movers_.gather_impulses(island);
  return is_bounded;
}

void ContactCore::widen_responses(const ContactIsland& island) {
  for (const ContactRows& rows : rows_of(island))
    for (std::size_t lane = 0; lane < ContactRows::kLanes; ++lane) {
      if (!(rows.is_widened[lane] > 0.0)) continue;
      movers_.widen(rows.a[lane]);
      movers_.widen(rows.b[lane]);
    }
}

/// Makes the responses of those anew whose touches are bounded by more than before, of all where a
/// substep begins; returns the ratio to masses.
double ContactCore::bound_responses(const ContactIsland& island, double substep_s, bool begins,
                                    const ExplicitState& state) {
  movers_.begin_responses(island, begins);
  if (!begins) widen_responses(island);
  double spring_share = 0.0;
  for (const ContactRows& rows : rows_of(island)) {
    for (std::size_t lane = 0; lane < ContactRows::kLanes; ++lane) {
      const ImpulseSlopes slopes{rows.normal_bound_kg[lane], rows.across_bound_kg[lane]};
      if (!(slopes.normal_kg > 0.0)) continue;
      spring_share = std::max(spring_share, 0.25 * substep_s * substep_s *
                                                rows.stiffness_N_per_m[lane] / slopes.normal_kg);
      const Eigen::Vector3d normal = ContactRows::get(rows.normal, lane);
      const double weights = rows.weights[lane];
      movers_.add_slopes(rows.a[lane], ContactRows::get(rows.arm_a_m, lane), normal, slopes,
                         weights);
      movers_.add_slopes(rows.b[lane], ContactRows::get(rows.arm_b_m, lane), normal, slopes,
                         weights);
    }
  }
  const double ratio = movers_.invert_responses(island, state);
  stiffness_ratio_ = std::max(stiffness_ratio_, spring_share * ratio);
  return ratio;
}

ContactSolve ContactCore::solve_island(const ContactIsland& island, double substep_s,
                                       const Budget& budget, ExplicitState& state) {
  ContactSolve result;
  const double rounding_m_s = kRounding * movers_.largest_m_s(island) + kRounding_m_s;
  const bool is_large = island.touches.last - island.touches.first > kLargeIsland;
  double ratio = 0.0;
  ChebyshevWeights weights;
  for (bool begins = true;; begins = false) {
    if (!begins) movers_.place_points(island, state);
    const bool is_bounded = evaluate(island, substep_s);
    const ContactResidual residual = movers_.residual(island, state);
    result.residual_m_s = residual.left_m_s;
    if (residual.left_m_s <= std::max(accuracy_.relative * residual.change_m_s, rounding_m_s))
      return result;
    if (!std::isfinite(residual.left_m_s)) result.converged = false;
    result.late = is_large && result.iterations % kIterationsALook == kIterationsALook - 1 &&
                  budget.is_late();
    if (result.late || result.iterations == accuracy_.most_iterations) result.converged = false;
    if (!result.converged) return result;
    ++result.iterations;
    const bool overshot = !begins && residual.is_uphill;
    if (is_bounded && !begins && !overshot) {
      const ChebyshevWeights::Next next = weights.next();
      movers_.advance(island, next.momentum, next.residual, state);
      continue;
    }
    // What comes and goes is no linear system: where Chebyshev's weights led away they begin anew
    // and more carefully, in the end as steps of weight 1, each of which comes nearer.
    if (!is_bounded || begins) ratio = bound_responses(island, substep_s, begins, state);
    weights = ChebyshevWeights(overshot ? kCareful * weights.ratio() : kTypicalBound * ratio);
    movers_.advance(island, 0.0, overshot ? 1.0 : weights.first(), state);
  }
}

}  // namespace stillgrid::dynamics
