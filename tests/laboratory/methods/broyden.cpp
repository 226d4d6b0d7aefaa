#include "tests/laboratory/methods/broyden.hpp"

#include <cmath>

#include "tests/laboratory/methods/implicit_integrator.hpp"

namespace stillgrid::laboratory {

dynamics::SolveReport BroydenSolver::solve(dynamics::NonlinearSystem& system, Eigen::VectorXd& u,
                                           dynamics::Budget& budget) {
  residual_.resize(u.size());
  system.residual(u, residual_);
  dynamics::SolveReport report;
  double error = dynamics::scaled_rms(system, residual_);
  report.residual = error;
  best_ = u;
  if (!(error <= tolerance_) && !budget.spent() && std::isfinite(error)) {
    for (std::size_t taken = 0; !(error <= tolerance_) && !budget.spent(); ++taken) {
      find_step(system, taken);
      ++report.iterations;
      --budget.iterations;
      u += steps_[taken];
      system.residual(u, residual_);
      error = dynamics::scaled_rms(system, residual_);
      // Nothing brings it back from what is no number, or from an estimate that lost its inverse.
      if (!std::isfinite(error)) break;
      if (error < report.residual) {
        report.residual = error;
        best_ = u;
      }
    }
  }
  u = best_;
  system.residual(u, residual_);
  report.converged = report.residual <= tolerance_;
  return report;
}

/// The step number `taken`, from the residual and the steps before.
void BroydenSolver::find_step(const dynamics::NonlinearSystem& system, std::size_t taken) {
  if (steps_.size() <= taken) {
    steps_.emplace_back();
    squares_.push_back(0.0);
  }
  Eigen::VectorXd& step = steps_[taken];
  step = -residual_.cwiseQuotient(system.mass_diagonal());
  // H_k = (1 + s_k s_(k-1)' / |s_(k-1)|^2) H_(k-1), by Sherman and Morrison; the last factor holds
  // the step sought itself.
  for (std::size_t j = 0; j + 1 < taken; ++j)
    step += steps_[j].dot(step) / squares_[j] * steps_[j + 1];
  if (taken > 0) step /= 1.0 - steps_[taken - 1].dot(step) / squares_[taken - 1];
  squares_[taken] = step.squaredNorm();
}

std::unique_ptr<dynamics::Integrator> make_broyden(const scene::Method& method) {
  return std::make_unique<ImplicitIntegrator>(
      std::make_unique<BroydenSolver>(method.tolerance_m_s));
}

}  // namespace stillgrid::laboratory
