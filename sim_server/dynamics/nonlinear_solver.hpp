#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace stillgrid {

/// Which derivative of the residual a solver asks for.
enum class Slope {
  kExact,     // the true one: fast near the solution, but it may lead to a saddle or nowhere
  kDefinite,  // symmetric positive definite: what softens is left out, so that its steps go
              // downhill
};

/// A system of equations r(u) = 0: what an implicit integrator asks of a solver.
class NonlinearSystem {
 public:
  NonlinearSystem() = default;
  virtual ~NonlinearSystem() = default;
  NonlinearSystem(const NonlinearSystem&) = delete;
  NonlinearSystem& operator=(const NonlinearSystem&) = delete;
  NonlinearSystem(NonlinearSystem&&) = delete;
  NonlinearSystem& operator=(NonlinearSystem&&) = delete;

  [[nodiscard]] virtual Eigen::Index size() const = 0;

  /// r(u). Pre: residual.size() == u.size() == size().
  virtual void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) = 0;

  /// dr/du at the u of the last residual().
  virtual void jacobian(Slope slope, Eigen::SparseMatrix<double>& matrix) = 0;

  /// Factors, one an equation, that turn each residual into an error of u in one common unit.
  [[nodiscard]] virtual const Eigen::VectorXd& residual_scale() const = 0;
};

/// How a solve ended. The residual is scaled, rms over the equations.
struct SolveReport {
  bool converged = false;
  int iterations = 0;
  double residual = 0.0;
};

/// Solves a NonlinearSystem from a first guess; bounded in iterations.
class NonlinearSolver {
 public:
  NonlinearSolver() = default;
  virtual ~NonlinearSolver() = default;
  NonlinearSolver(const NonlinearSolver&) = delete;
  NonlinearSolver& operator=(const NonlinearSolver&) = delete;
  NonlinearSolver(NonlinearSolver&&) = delete;
  NonlinearSolver& operator=(NonlinearSolver&&) = delete;

  /// Leaves in u the solution, or the iterate of least residual if none was good enough.
  virtual SolveReport solve(NonlinearSystem& system, Eigen::VectorXd& u) = 0;
};

}  // namespace stillgrid
