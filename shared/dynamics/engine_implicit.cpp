// A tick by implicit Euler.
#include <algorithm>

#include "shared/dynamics/engine.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr int kHalvings = 10;        // of a step in which something would pass through a body
constexpr int kHalvingsToSolve = 4;  // of one whose equations are not solved
constexpr int kListings = 3;         // of one part, as its solution moves on

}  // namespace

void Engine::implicit_tick(double tick_s) {
  solve_ = {};
  implicit_part(tick_s, kHalvings);
}

/// Solves for the end of a part. False if something would pass through a body.
bool Engine::solve_part(double h) {
  solve_.converged = true;
  implicit_->start(state_, h);
  implicit_->restart(listing_);
  if (implicit_->passes()) return false;
  for (int k = 0;; ++k) {
    implicit_->solve(solve_);
    if (implicit_->passes()) return false;
    if (implicit_->is_within(listing_)) return true;
    if (k == kListings) return false;
    ahead_ = state_;  // contacts of the ways that the solution leads
    implicit_->write_velocities(ahead_);
    listing_.list(ahead_, h);
    adopt_listing();
    implicit_->restart(listing_);
  }
}

/// Halves the part where it has no solution: shorter steps are nearer to their start.
void Engine::implicit_part(double h, int halvings) {
  if (!listing_holds(h)) list_contacts(h);
  const bool was_solved = solve_.converged, stays_out = solve_part(h);
  const bool is_divided =
      stays_out ? !solve_.converged && halvings > kHalvings - kHalvingsToSolve : halvings > 0;
  solve_.converged = was_solved && (is_divided || solve_.converged);
  if (is_divided) {
    implicit_part(0.5 * h, halvings - 1);
    implicit_part(0.5 * h, halvings - 1);
    return;
  }
  ++solve_.parts;
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    reactions_[k].impulse_N_s += implicit_->impulse_N_s(driven_[k]);
    reactions_[k].moment_N_m_s += implicit_->moment_N_m_s(driven_[k]);
  }
  implicit_->finish(state_, listing_.rows());
}

}  // namespace stillgrid::dynamics
