#pragma once

#include <memory>

#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::laboratory {

/// How KINSOL seeks the solution.
enum class KinsolStrategy {
  kNewtonKrylov,  // Newton's steps by GMRES on the exact Jacobian as an operator, preconditioned by
                  // its inverted diagonal blocks, cut short by a line search
  kAnderson,  // the fixed point u - D^-1 r(u), D the diagonal blocks of the definite Jacobian at
              // the first guess, accelerated over the last five iterates [Anderson 1965]
};

/// SUNDIALS' KINSOL as a solver (docs/algorithms/sundials.md). It stops, as any solver here, when
/// the scaled residual's rms is within the tolerance.
class KinsolSolver : public dynamics::NonlinearSolver {
 public:
  KinsolSolver(KinsolStrategy strategy, double tolerance);
  ~KinsolSolver() override;
  dynamics::SolveReport solve(dynamics::NonlinearSystem& system, Eigen::VectorXd& u,
                              dynamics::Budget& budget) override;

 private:
  struct Run;
  KinsolStrategy strategy_;
  double tolerance_;
  std::unique_ptr<Run> run_;  // of the size last solved
};

/// tolerance: of the scaled residual, rms.
[[nodiscard]] std::unique_ptr<dynamics::NonlinearSolver> make_kinsol_newton_krylov(
    double tolerance);
[[nodiscard]] std::unique_ptr<dynamics::NonlinearSolver> make_kinsol_anderson(double tolerance);
/// As a scene names them.
inline constexpr scene::SolverKind kKinsolNewtonKrylov{"kinsol_newton_krylov", false,
                                                       make_kinsol_newton_krylov};
inline constexpr scene::SolverKind kKinsolAnderson{"kinsol_anderson", false, make_kinsol_anderson};

}  // namespace stillgrid::laboratory
