// The solution of an island's contacts in a substep.

#include <algorithm>
#include <atomic>
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

/// Pushes of all contacts at the velocities of the island's points; whether they may change by no
/// more than the responses count on.
bool ContactCore::evaluate(const ContactIsland& island, double substep_s, const Workers& workers) {
  std::atomic<bool> is_bounded = true;
  workers.for_each_chunk(
      island.rows.last - island.rows.first, kRowsAChunk, [&](std::size_t first, std::size_t last) {
        const std::size_t row = island.rows.first + first;
        if (!evaluate_rows(std::span(rows_).subspan(row, last - first), movers_.velocities(),
                           std::span(pushes_).subspan(row * ContactRows::kLanes), substep_s))
          is_bounded.store(false, std::memory_order_relaxed);
      });
  return is_bounded;
}

ContactSolve ContactCore::solve_island(const ContactIsland& island, double substep_s,
                                       const Budget& budget, ExplicitState& state,
                                       const Workers& workers) {
  ContactSolve result;
  const double rounding_m_s = kRounding * movers_.largest_m_s(island) + kRounding_m_s;
  const bool is_large = island.touches.last - island.touches.first > kLargeIsland;
  ResponseBound bound;
  ChebyshevWeights weights;
  for (bool begins = true;; begins = false) {
    const bool is_bounded = evaluate(island, substep_s, workers);
    const ContactResidual residual = movers_.residual(island, pushes_, state, workers);
    result.residual_m_s = residual.left_m_s;
    if (residual.left_m_s <= std::max(accuracy_.relative * residual.change_m_s, rounding_m_s))
      return result;
    if (!std::isfinite(residual.left_m_s)) result.converged = false;
    result.late = is_large && result.iterations % kIterationsALook == kIterationsALook - 1 &&
                  budget.is_late();
    if (result.late || result.iterations == accuracy_.most_iterations) result.converged = false;
    if (!result.converged) return result;
    ++result.iterations;
    const bool overshot = !begins && residual.along_J < 0.0;
    if (is_bounded && !begins && !overshot) {
      const ChebyshevWeights::Next next = weights.next();
      movers_.advance(island, next.momentum, next.residual, state, workers);
      continue;
    }
    // What comes and goes is no linear system: where Chebyshev's weights led away they begin anew
    // and more carefully, in the end as steps of weight 1, each of which comes nearer.
    if (!is_bounded || begins)
      bound = movers_.make_responses(island, rows_, begins, substep_s, state, workers);
    result.stiffness_ratio = std::max(result.stiffness_ratio, bound.spring_share * bound.ratio);
    weights = ChebyshevWeights(overshot ? kCareful * weights.ratio() : kTypicalBound * bound.ratio);
    movers_.advance(island, 0.0, overshot ? 1.0 : weights.first(), state, workers);
  }
}

void ContactSolve::add(const ContactSolve& more) {
  iterations = std::max(iterations, more.iterations);
  residual_m_s = std::max(residual_m_s, more.residual_m_s);
  stiffness_ratio = std::max(stiffness_ratio, more.stiffness_ratio);
  converged = converged && more.converged;
  late = late || more.late;
}

}  // namespace stillgrid::dynamics
