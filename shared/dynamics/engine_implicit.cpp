// A tick by implicit Euler.
#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/implicit_step.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr int kHalvings = 12;        // of a step in which something would pass through a body
constexpr int kHalvingsToSolve = 4;  // of one whose equations are not solved
constexpr int kListings = 3;         // of one part, as its solution moves on

}  // namespace

void Engine::implicit_tick(double tick_s) {
  solve_ = {};
  implicit_part(tick_s, kHalvings);
  substeps_ = solve_.parts;
}

/// Solves for the end of a part. False if something would pass through a body.
bool Engine::solve_part(double h) {
  solve_.converged = true;
  implicit_->start(state_, h);
  implicit_->restart(listing_);
  if (implicit_->passes()) return false;
  for (int k = 0;; ++k) {
    implicit_->solve(solve_, stop_);
    if (stop_ != nullptr && *stop_) return true;
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

void Engine::note_implicit_reactions() {
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    reactions_[k].impulse_N_s += implicit_->impulse_N_s(driven_[k]);
    reactions_[k].moment_N_m_s += implicit_->moment_N_m_s(driven_[k]);
  }
  const auto driven_of = [&](const ActedPoint& point) {
    return point.rigid < 0 ? -1 : driven_of_rigid_[static_cast<std::size_t>(point.rigid)];
  };
  for (const Coupling& contact : implicit_->contacts()) {
    const std::int32_t a = driven_of(contact.a), b = driven_of(contact.b);
    if (a < 0 || b < 0) continue;
    const auto note = [&](std::int32_t driven, const ActedPoint& point, double sign) {
      DrivenReaction& reaction = reactions_[static_cast<std::size_t>(driven)];
      reaction.rigid_impulse_N_s += sign * contact.impulse_N_s;
      reaction.rigid_moment_N_m_s += sign * point.arm_m.cross(contact.impulse_N_s);
    };
    note(a, contact.a, 1.0);
    note(b, contact.b, -1.0);
  }
}

/// Halves the part where it has no solution: shorter steps are nearer to their start.
void Engine::implicit_part(double h, int halvings) {
  if (stop_ != nullptr && *stop_) return;
  if (!listing_holds(h)) list_contacts(h);
  const SolveFigures before = solve_;
  const bool stays_out = solve_part(h);
  const bool is_divided =
      stays_out ? !solve_.converged && halvings > kHalvings - kHalvingsToSolve : halvings > 0;
  solve_.converged = before.converged && (is_divided || solve_.converged);
  solve_.residual_m_s = is_divided ? before.residual_m_s
                                   : worse_residual_m_s(before.residual_m_s, solve_.residual_m_s);
  if (is_divided) {
    implicit_part(0.5 * h, halvings - 1);
    implicit_part(0.5 * h, halvings - 1);
    return;
  }
  ++solve_.parts;
  solve_.passes += stays_out ? 0 : 1;
  note_implicit_reactions();
  if (counts_losses_) meter_.add(implicit_->losses());
  implicit_->finish(state_, listing_, bodies_.places);
}

}  // namespace stillgrid::dynamics
