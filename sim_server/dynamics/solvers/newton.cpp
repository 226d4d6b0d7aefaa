#include "sim_server/dynamics/solvers/newton.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::dynamics {
namespace {

// After an exact step failed, this much less of the residual makes the next one worth its cost.
constexpr double kRetryBelow = 0.1;
// A step along a symmetric Jacobian that leaves more of the residual is slow.
constexpr double kSlow = 0.2;
// After so many slow steps in a row, and every so many that left much for whatever reason, the
// exact Jacobian is tried: it costs several times as much.
constexpr int kSlowInRow = 2, kTryAgain = 5;
// Of the residual: the first step of a solver that iterates leaves so much.
constexpr double kFirstAccuracy = 0.1;

}  // namespace

SolveReport NewtonSolver::solve(NonlinearSystem& system, Eigen::VectorXd& u, Budget& budget) {
  residual_.resize(u.size());
  trial_residual_.resize(u.size());
  system.residual(u, residual_);
  error_ = scaled_rms(system, residual_);
  SolveReport report;
  const long products_before = linear_solver_.products();
  double try_exact_below = INFINITY;
  double least_error = error_;
  int slow_in_row = 0, left_much = 0;
  bool stuck = false;
  accuracy_ = kFirstAccuracy;
  best_ = u;
  while (!(error_ <= tolerance_) && !budget.spent()) {
    ++report.iterations;
    --budget.iterations;
    accuracy_ = std::clamp(accuracy_, std::min(0.5 * tolerance_ / error_, 0.1), 0.1);
    const double before = error_;
    const bool wanted = slow_in_row >= kSlowInRow || left_much >= kTryAgain;
    const bool try_exact = wanted && error_ < try_exact_below;
    if (try_exact) left_much = 0;
    if (!try_exact || !exact_step(system, u, budget)) {
      if (try_exact) try_exact_below = kRetryBelow * error_;
      stuck = !descent_step(system, u, budget);
      if (stuck) break;
      const bool is_slow = error_ > kSlow * before;
      if (is_slow) ++left_much;
      // A shortened step met a kink, of which the exact Jacobian knows no more.
      slow_in_row = is_slow && length_ == 1.0 ? slow_in_row + 1 : 0;
    }
    // No more accurate than the residual's fall promises.
    accuracy_ = 0.9 * (error_ / before) * (error_ / before);
    if (error_ < least_error) {
      least_error = error_;
      best_ = u;
    }
  }
  if (stuck || !(error_ <= least_error)) {
    u = best_;
    system.residual(u, residual_);
  }
  report.residual = least_error;
  report.converged = least_error <= tolerance_;
  report.products = linear_solver_.products() - products_before;
  return report;
}

/// Evaluates u - length * step; false if the result is no number.
bool NewtonSolver::load_trial(NonlinearSystem& system, const Eigen::VectorXd& u, double length) {
  trial_ = u - length * step_;
  system.residual(trial_, trial_residual_);
  trial_error_ = scaled_rms(system, trial_residual_);
  return std::isfinite(trial_error_);
}

void NewtonSolver::take_trial(Eigen::VectorXd& u) {
  u.swap(trial_);
  residual_.swap(trial_residual_);
  error_ = trial_error_;
}

bool NewtonSolver::exact_step(NonlinearSystem& system, Eigen::VectorXd& u, const Budget& budget) {
  if (!linear_solver_.solve(system, JacobianKind::kExact, residual_, accuracy_, budget, step_))
    return false;
  // A step against which the residual does not work leads uphill, to a saddle perhaps.
  if (!(step_.dot(residual_) > 0.0)) return false;
  if (load_trial(system, u, 1.0) && trial_error_ <= 0.5 * error_) {
    take_trial(u);
    return true;
  }
  system.residual(u, residual_);  // the state that the next Jacobian is of
  return false;
}

bool NewtonSolver::descent_step(NonlinearSystem& system, Eigen::VectorXd& u, const Budget& budget) {
  const bool symmetric =
      linear_solver_.solve(system, JacobianKind::kSymmetric, residual_, accuracy_, budget, step_);
  if (!symmetric &&
      !linear_solver_.solve(system, JacobianKind::kDefinite, residual_, accuracy_, budget, step_))
    return false;

  // step . residual is the Jacobian along the step; past the valley it turns negative. Regula falsi
  // finds where, to half the first Jacobian.
  const double first_derivative = step_.dot(residual_);
  double length = 1.0, near = 0.0, near_derivative = first_derivative;
  for (int trial = 0; trial < 12; ++trial) {
    if (budget.is_stopped()) return false;
    length_ = length;
    if (!load_trial(system, u, length)) {
      length *= 0.1;
      continue;
    }
    const double derivative = step_.dot(trial_residual_);
    if (derivative >= -0.5 * first_derivative) break;
    const double zero = near + (length - near) * near_derivative / (near_derivative - derivative);
    length = std::clamp(zero, near + 0.1 * (length - near), near + 0.9 * (length - near));
  }
  if (!std::isfinite(trial_error_)) return false;
  take_trial(u);
  return true;
}

}  // namespace stillgrid::dynamics
