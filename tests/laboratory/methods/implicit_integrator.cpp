#include "tests/laboratory/methods/implicit_integrator.hpp"

#include <array>
#include <cmath>

namespace stillgrid::laboratory {
namespace {

constexpr std::size_t kMaxBrakes = 24;  // of a step that did not converge

}  // namespace

dynamics::SolveReport ImplicitIntegrator::advance(const bodies::World& world,
                                                  std::span<const contact::Contact> contacts,
                                                  double duration_s, dynamics::Budget& budget) {
  load(world, contacts);
  const Eigen::VectorXd start_velocity = system_.velocity();
  velocity_ = start_velocity;
  dynamics::ImplicitStage stage(system_, duration_s);
  const dynamics::SolveReport report = solver_->solve(stage, velocity_, budget);
  displacement_ = stage.displacement();
  if (!report.converged && budget.is_stopped()) return report;
  const bool is_finite = report.converged || make_safe(start_velocity, duration_s);
  end_with(contacts, duration_s);
  trial_.is_finite = is_finite;
  return report;
}

/// A world with contacts that begin as the last step that was committed left them.
void ImplicitIntegrator::load(const bodies::World& world,
                              std::span<const contact::Contact> contacts) {
  memories_.take(world, contacts);
  memories_.stretches(contacts, stretches_m_);
  system_.take(world, contacts, stretches_m_, dynamics::Levers::kMean);
}

/// The step ends where the system is placed: the trial, and what the memories become.
void ImplicitIntegrator::end_with(std::span<const contact::Contact> contacts, double duration_s) {
  system_.stretches(duration_s, ended_m_);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::uint32_t contact = memories_.places()[i].contact;
    memories_[i].stretch_m =
        dynamics::is_turned(contacts[contact]) ? -ended_m_[contact] : ended_m_[contact];
  }
  trial_ = system_.trial();
  trial_.start_stretches_m = stretches_m_;
  trial_.takes_end_forces = true;
  trial_.stretch_gain_J = memories_.ended_energy_J() - memories_.energy_J();
}

/// Brakes a step that gained energy until it does not. Returns whether the step was finite.
bool ImplicitIntegrator::make_safe(const Eigen::VectorXd& start_velocity, double duration_s) {
  system_.place(Eigen::VectorXd::Zero(system_.size()), start_velocity, duration_s);
  const double start_J = system_.energy_J();
  const bool is_finite =
      std::isfinite(start_J) && displacement_.allFinite() && velocity_.allFinite();
  const double most_J = start_J + 1e-12 * std::abs(start_J);  // rounding is no gain
  // A small gain takes a little of the speed, not half.
  constexpr std::array<double, 4> kFirstBrakes = {1.0, 0.98, 0.9, 0.7};
  for (std::size_t brakes = 0; brakes <= kMaxBrakes; ++brakes) {
    const bool is_last = brakes == kMaxBrakes;
    const double brake = brakes < kFirstBrakes.size() ? kFirstBrakes[brakes] : 0.5;
    displacement_ *= brake;
    velocity_ *= brake;
    if (is_last || !is_finite) {  // at rest where it was
      displacement_.setZero(system_.size());
      velocity_.setZero(system_.size());
    }
    system_.place(displacement_, velocity_, duration_s);
    if (is_last || !is_finite || system_.energy_J() <= most_J) break;
  }
  Eigen::VectorXd force;
  system_.force(duration_s, force);  // counts the contacts that touch there
  return is_finite;
}

void ImplicitIntegrator::commit(bodies::World& world, double duration_s) {
  dynamics::Integrator::commit(world, duration_s);
  memories_.keep();
}

}  // namespace stillgrid::laboratory
