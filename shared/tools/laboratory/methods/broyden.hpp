#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::laboratory {

/// What Broyden's method takes for the Jacobian at first.
enum class BroydenStart {
  kMass,      // the mass diagonal: no matrix is ever formed [Hilde, Meseure, Chaillou 2001]
  kJacobian,  // the definite Jacobian at the first guess, factorised once
};

/// Broyden's (first, "good") method: every step adds to the Jacobian's estimate what the last step
/// taught, by a matrix of rank one, so that a system costs one residual an iteration.
///
/// Full steps and no safeguard, as published: on stiff systems it needs many iterations or none
/// suffices (docs/algorithms/broyden.md). It then returns the best iterate, as any solver here.
/// The inverse is kept as a product of rank-one factors in the steps themselves [Kelley 1995,
/// section 7.3]: iteration k costs k dot products and k vectors of memory.
class BroydenSolver : public dynamics::NonlinearSolver {
 public:
  /// tolerance: of the scaled residual, rms.
  BroydenSolver(BroydenStart start, double tolerance) : start_(start), tolerance_(tolerance) {}
  dynamics::SolveReport solve(dynamics::NonlinearSystem& system, Eigen::VectorXd& u,
                              dynamics::Budget& budget) override;

 private:
  bool prepare(dynamics::NonlinearSystem& system);
  void find_step(const dynamics::NonlinearSystem& system, std::size_t taken);

  BroydenStart start_;
  double tolerance_;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky_;
  std::vector<Eigen::VectorXd> steps_;  // memory is kept from one solve to the next
  std::vector<double> squares_;         // of their norms
  Eigen::VectorXd residual_, best_;
};

/// tolerance: as BroydenSolver's.
[[nodiscard]] std::unique_ptr<dynamics::NonlinearSolver> make_broyden(double tolerance);
[[nodiscard]] std::unique_ptr<dynamics::NonlinearSolver> make_broyden_from_mass(double tolerance);
/// As a scene names them: from the Jacobian at the step's start; from the mass, the paper's.
inline constexpr scene::SolverKind kBroyden{"broyden", true, make_broyden};
inline constexpr scene::SolverKind kBroydenMass{"broyden_mass", false, make_broyden_from_mass};

}  // namespace stillgrid::laboratory
