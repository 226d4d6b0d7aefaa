#include "sim_server/dynamics/newton.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid {
SolveReport NewtonSolver::solve(NonlinearSystem& system, Eigen::VectorXd& u, Budget& budget) {
  residual_.resize(u.size());
  trial_residual_.resize(u.size());
  system.residual(u, residual_);
  error_ = scaled_rms(system, residual_);
  SolveReport report;
  // After an exact step failed, this much less of the residual makes the next one worth its cost.
  constexpr double kRetryBelow = 0.1;
  double try_exact_below = INFINITY;
  double least_error = error_;
  best_ = u;
  while (!(error_ <= tolerance_) && !budget.spent()) {
    ++report.iterations;
    --budget.iterations;
    const bool try_exact = error_ < try_exact_below;
    if (!try_exact || !exact_step(system, u)) {
      if (try_exact) try_exact_below = kRetryBelow * error_;
      if (!definite_step(system, u)) break;
    }
    if (error_ < least_error) {
      least_error = error_;
      best_ = u;
    }
  }
  u = best_;
  system.residual(u, residual_);
  report.residual = least_error;
  report.converged = least_error <= tolerance_;
  return report;
}

/// Evaluates u - length * step; false if the result is no number.
bool NewtonSolver::load_trial(NonlinearSystem& system, const Eigen::VectorXd& u, double length) {
  trial_ = u - length * step_;
  system.residual(trial_, trial_residual_);
  trial_error_ = scaled_rms(system, trial_residual_);
  return std::isfinite(trial_error_);
}

bool NewtonSolver::exact_step(NonlinearSystem& system, Eigen::VectorXd& u) {
  system.jacobian(Slope::kExact, matrix_);
  lu_.compute(matrix_);
  if (lu_.info() == Eigen::Success) {
    step_ = lu_.solve(residual_);
    // A step against which the residual does not work leads uphill, to a saddle perhaps.
    const bool downhill = step_.allFinite() && step_.dot(residual_) > 0.0;
    if (downhill && load_trial(system, u, 1.0) && trial_error_ <= 0.5 * error_) {
      u.swap(trial_);
      residual_.swap(trial_residual_);
      error_ = trial_error_;
      return true;
    }
  }
  system.residual(u, residual_);  // the state that the next Jacobian is of
  return false;
}

bool NewtonSolver::definite_step(NonlinearSystem& system, Eigen::VectorXd& u) {
  system.jacobian(Slope::kDefinite, matrix_);
  cholesky_.compute(matrix_);
  if (cholesky_.info() != Eigen::Success) return false;
  step_ = cholesky_.solve(residual_);
  if (!step_.allFinite()) return false;

  // step . residual is the slope along the step; past the valley it turns negative. Regula falsi
  // finds where, to half the first slope.
  const double first_slope = step_.dot(residual_);
  double length = 1.0, near = 0.0, near_slope = first_slope;
  for (int trial = 0; trial < 12; ++trial) {
    if (!load_trial(system, u, length)) {
      length *= 0.1;
      continue;
    }
    const double slope = step_.dot(trial_residual_);
    if (slope >= -0.5 * first_slope) break;
    const double zero = near + (length - near) * near_slope / (near_slope - slope);
    length = std::clamp(zero, near + 0.1 * (length - near), near + 0.9 * (length - near));
  }
  if (!std::isfinite(trial_error_)) return false;
  u.swap(trial_);
  residual_.swap(trial_residual_);
  error_ = trial_error_;
  return true;
}

}  // namespace stillgrid
