#pragma once

#include <memory>

#include "sim_server/dynamics/integrators/integrator.hpp"

namespace stillgrid {

/// SUNDIALS' integrators, for accuracy on demand: they choose order and steps so that the error of
/// each of their steps stays below a tolerance (docs/algorithms/sundials.md).
///   kCvodeBdf: CVODE's backward differentiation formulas of order 1 to 5;
///   kArkodeDirk: ARKODE's diagonally implicit Runge-Kutta method of order 4.
/// Of a step that fails, the state last reached is the trial: time runs late, nothing leaps.
///
/// CVODE's history is kept from one advance() to the next while the world is the one committed and
/// nothing may touch, or contacts go on; else it begins anew at order 1.
class SundialsIntegrator : public Integrator {
 public:
  /// tolerance_m_s: of a step's error: relative; of velocities, and of displacements times the
  /// duration of the first advance() since its history began. Pre: kind is one of the above.
  SundialsIntegrator(IntegratorKind kind, double tolerance_m_s);
  ~SundialsIntegrator() override;

  [[nodiscard]] IntegratorTraits traits() const noexcept override {
    return {.most_iterations = 20'000};
  }

  /// An iteration of the budget is a step of SUNDIALS; so are those reported.
  SolveReport advance(const World& world, std::span<const Contact> contacts, double duration_s,
                      Budget& budget) override;
  void commit(World& world, double duration_s) override;
  void restart() override;

 private:
  struct Run;
  IntegratorKind kind_;
  double tolerance_m_s_;
  std::unique_ptr<Run> run_;   // since its history began
  bool run_is_world_ = false;  // the last trial was committed
};

/// The same. Throws std::runtime_error in a build without SUNDIALS (that for 64-bit ARM).
[[nodiscard]] std::unique_ptr<Integrator> make_sundials_integrator(IntegratorKind kind,
                                                                   double tolerance_m_s);

}  // namespace stillgrid
