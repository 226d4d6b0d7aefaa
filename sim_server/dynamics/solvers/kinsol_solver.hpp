#pragma once

#include <memory>

#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid {

/// SUNDIALS' KINSOL as a solver (docs/algorithms/sundials.md):
///   kKinsolNewtonKrylov: Newton's steps by GMRES on the exact Jacobian as an operator,
///   block-Jacobi
///     preconditioned, cut short by a line search;
///   kKinsolAnderson: the fixed point u - D^-1 r(u), D the diagonal blocks of the definite Jacobian
///   at
///     the first guess, accelerated over the last five iterates [Anderson 1965].
/// It stops, as any solver here, when the scaled residual's rms is within the tolerance.
class KinsolSolver : public NonlinearSolver {
 public:
  /// Pre: kind is one of the two above.
  KinsolSolver(SolverKind kind, double tolerance);
  ~KinsolSolver() override;
  SolveReport solve(NonlinearSystem& system, Eigen::VectorXd& u, Budget& budget) override;

 private:
  struct Run;
  SolverKind kind_;
  double tolerance_;
  std::unique_ptr<Run> run_;  // of the size last solved
};

/// The same. Throws std::runtime_error in a build without SUNDIALS (that for 64-bit ARM).
[[nodiscard]] std::unique_ptr<NonlinearSolver> make_kinsol_solver(SolverKind kind,
                                                                  double tolerance);

}  // namespace stillgrid
