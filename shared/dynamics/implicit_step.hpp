#pragma once

#include <Eigen/Core>
#include <atomic>
#include <vector>

#include "shared/dynamics/conjugate_gradients.hpp"
#include "shared/dynamics/coupled_step.hpp"
#include "shared/dynamics/engine_method.hpp"
#include "shared/dynamics/implicit_coupling.hpp"
#include "shared/dynamics/implicit_springs.hpp"

namespace stillgrid::dynamics {

/// One step of implicit Euler: M (v1 - v0) = h f(x1, v1) + h M g with x1 = x0 + h v1. It moves
/// nodes and rigid bodies by springs, joints, contacts and friction.
///
/// Solves by Newton's method. Conjugate gradients solve each linear system without a matrix. The
/// derivative is symmetric and positive definite: parts of it that are not are left out. A solved
/// step never gains energy: each force does at most the work that its potential loses. A rotation
/// keeps angular momentum.
///
/// Deterministic.
class ImplicitStep : public CoupledStep {
 public:
  ImplicitStep(const Description& description, double tolerance_m_s);

  void leave_out(const Sleep& sleep) override;
  void start(const SceneState& state, double step_s) override;
  /// Evaluates the guess, too.
  void restart(const ContactListing& listing) override;
  /// Realtime: never allocates, locks or throws.
  void solve(SolveFigures& figures, const std::atomic<bool>* stop) override;
  /// Whether it also turns a body too far for the work of its forces to be exact.
  [[nodiscard]] bool passes() const override { return CoupledStep::passes() || turns_far(); }
  [[nodiscard]] EnergyLosses losses() const override;

 protected:
  /// Computes impulses, the residual and all slopes at the trial velocities.
  void evaluate();
  /// Sets the limits of friction by the last evaluate(), and evaluates with them.
  void limit_friction();
  /// Returns the rms of the last residual over all free nodes and bodies, divided by mass. A
  /// rotation counts as the speed at the body's farthest point.
  [[nodiscard]] double residual_m_s() const;

  double tolerance_m_s_;
  Motions residual_;  // zero of driven bodies and pinned nodes

 private:
  void evaluate_body(std::size_t rigid);
  void collect_active();
  [[nodiscard]] bool turns_far() const;
  void multiply(const Motions& p, Motions& out) const;
  void factorise();
  void precondition(const Motions& r, Motions& out) const;
  double search_line();

  ImplicitSprings springs_;
  std::vector<Coupling> joints_;
  std::vector<const Coupling*> active_;  // joints and contacts of the last evaluate()
  ConjugateGradients gradients_;
  MassBlocks inverses_;                       // blocks on the diagonal of the derivative
  std::vector<Eigen::Matrix3d> spin_masses_;  // inertia at the end, and how torques change
  Motions base_, wanted_, change_;
  std::vector<Vector4> momenta_;  // angular, of rigid bodies at the start
};

/// Ticks by implicit Euler.
[[nodiscard]] EngineMethod implicit_euler(double tolerance_m_s = 1e-8);

}  // namespace stillgrid::dynamics
