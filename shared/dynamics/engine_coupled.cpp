// A tick by a method that takes the whole scene at once.
#include "shared/dynamics/coupled_step.hpp"
#include "shared/dynamics/engine.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr int kHalvings = 12;        // of a step in which something would pass through a body
constexpr int kHalvingsToSolve = 4;  // of one whose equations are not solved
constexpr int kListings = 3;         // of one part, as its solution moves on

}  // namespace

void Engine::coupled_tick(double tick_s) {
  solve_ = {};
  coupled_part(tick_s, kHalvings);
  substeps_ = solve_.parts;
}

/// Solves for the end of a part. False if something would pass through a body. A part that may be
/// divided is not solved where its guess passes.
bool Engine::solve_part(double h, bool may_divide) {
  solve_.converged = true;
  coupled_->start(state_, h);
  coupled_->restart(listing_);
  if (may_divide && coupled_->passes()) return false;
  for (int k = 0;; ++k) {
    coupled_->solve(solve_, stop_);
    if (stop_ != nullptr && *stop_) return true;
    if (coupled_->passes()) return false;
    if (coupled_->is_within(listing_)) return true;
    if (k == kListings) return false;
    ahead_ = state_;  // contacts of the ways that the solution leads
    coupled_->write_velocities(ahead_);
    listing_.list(ahead_, h);
    adopt_listing();
    move_proxies(h);
    coupled_->restart(listing_);
  }
}

void Engine::note_coupled_reactions() {
  for (std::size_t k = 0; k < driven_.size(); ++k)
    coupled_->add_reaction(driven_[k], reactions_[k]);
}

/// Halves the part where it has no solution: shorter steps are nearer to their start. What the
/// method does not solve with the work of a tick is left to small steps.
void Engine::coupled_part(double h, int halvings) {
  if (stop_ != nullptr && *stop_) return;
  if (solve_.is_spent()) {
    solve_.converged = false;
    divided_tick(h, 0);
    solve_.parts += substeps_;
    return;
  }
  if (!listing_holds(h)) list_contacts(h);
  move_proxies(h);
  const SolveFigures before = solve_;
  // Whoever goes by in a part would push at its end alone, and be past.
  const bool goes_by = a_tool_goes_far_ && halvings > 0;
  const bool stays_out = !goes_by && solve_part(h, halvings > 0);
  const bool is_divided =
      stays_out ? !solve_.converged && halvings > kHalvings - kHalvingsToSolve : halvings > 0;
  solve_.converged = before.converged && (is_divided || solve_.converged);
  solve_.residual_m_s = is_divided ? before.residual_m_s
                                   : worse_residual_m_s(before.residual_m_s, solve_.residual_m_s);
  if (is_divided) {
    coupled_part(0.5 * h, halvings - 1);
    coupled_part(0.5 * h, halvings - 1);
    return;
  }
  ++solve_.parts;
  solve_.passes += stays_out ? 0 : 1;
  note_coupled_reactions();
  if (counts_losses_) meter_.add(coupled_->losses());
  substep_s_ = h;
  coupled_->finish(state_, listing_, bodies_.places);
  finish_proxies();
}

}  // namespace stillgrid::dynamics
