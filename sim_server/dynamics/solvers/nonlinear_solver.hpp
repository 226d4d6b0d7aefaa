#pragma once

#include <Eigen/Core>

#include "sim_server/dynamics/solvers/block_triangle.hpp"
#include "sim_server/dynamics/solvers/budget.hpp"

namespace stillgrid::dynamics {

/// Which derivative of the residual a solver asks for.
enum class JacobianKind {
  kExact,      // the true one, not symmetric where there is friction or rotation
  kSymmetric,  // without what is not symmetric: friction's change with pressure, gyroscopic terms,
               // the turning of levers; indefinite where something softens
  kDefinite,   // symmetric positive definite: what softens is left out too, so that its steps go
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

  /// A multiple of 3: unknowns come in blocks of three.
  [[nodiscard]] virtual Eigen::Index size() const = 0;

  /// r(u). Pre: residual.size() == u.size() == size().
  virtual void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) = 0;

  /// Computes dr/du at the u of the last residual() as an operator, for the functions below.
  virtual void linearise(JacobianKind kind) = 0;

  /// y = dr/du x, of the last linearise(). Pre: x.size() == size(), x and y are not the same.
  virtual void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const = 0;

  /// The 3 x 3 blocks on the diagonal of dr/du, side by side, of the last linearise().
  [[nodiscard]] virtual const Eigen::Matrix3Xd& block_diagonal() const = 0;

  /// A part of dr/du, as large as its form allows, of the last linearise(), which was not of
  /// kExact; for its user to factorise.
  [[nodiscard]] virtual BlockTriangle& triangle() = 0;

  /// y += (dr/du - triangle()) x. Pre: as multiply().
  virtual void add_rest(const Eigen::VectorXd& x, Eigen::VectorXd& y) const = 0;

  /// Whether add_rest() adds anything.
  [[nodiscard]] virtual bool has_rest() const = 0;

  /// What a unit of each unknown weighs without any force: dr/du as the step goes to zero.
  [[nodiscard]] virtual const Eigen::VectorXd& mass_diagonal() const = 0;

  /// Factors, one an equation, that turn each residual into an error of u in one common unit.
  [[nodiscard]] virtual const Eigen::VectorXd& residual_scale() const = 0;
};

/// Residual in the common unit of residual_scale(), rms over the equations; zero without any.
[[nodiscard]] double scaled_rms(const NonlinearSystem& system, const Eigen::VectorXd& residual);

/// How a solve ended. The residual is scaled, rms over the equations.
struct SolveReport {
  bool converged = false;
  int iterations = 0;
  long products = 0;  // with the Jacobian
  double residual = 0.0;
};

}  // namespace stillgrid::dynamics
