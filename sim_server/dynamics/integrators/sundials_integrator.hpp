#pragma once

#include <memory>

#include "sim_server/dynamics/integrators/integrator.hpp"

namespace stillgrid::dynamics {

struct SundialsProblem;
class SundialsStepper;
/// Begins one of SUNDIALS' integrators (sundials_stepper.hpp).
using MakeStepper = std::unique_ptr<SundialsStepper> (*)(const SundialsProblem& problem);

/// The equations of motion for SUNDIALS' integrators, for accuracy on demand: they choose order and
/// steps so that the error of each of their steps stays below a tolerance
/// (docs/algorithms/sundials.md). Of a step that fails, the state last reached is the trial: time
/// runs late, nothing leaps.
///
/// Their history is kept from one advance() to the next while the world is the one committed and
/// nothing may touch, or contacts go on; else it begins anew at order 1.
class SundialsIntegrator : public Integrator {
 public:
  /// tolerance_m_s: of a step's error: relative; of velocities, and of displacements times the
  /// duration of the first advance() since its history began.
  SundialsIntegrator(MakeStepper make_stepper, double tolerance_m_s);
  ~SundialsIntegrator() override;

  [[nodiscard]] IntegratorTraits traits() const noexcept override {
    return {.most_iterations = 20'000};
  }

  /// An iteration of the budget is a step of SUNDIALS; so are those reported.
  SolveReport advance(const bodies::World& world, std::span<const contact::Contact> contacts,
                      double duration_s, Budget& budget) override;
  void commit(bodies::World& world, double duration_s) override;
  void restart() override;

 private:
  struct Run;
  MakeStepper make_stepper_;
  double tolerance_m_s_;
  std::unique_ptr<Run> run_;   // since its history began
  bool run_is_world_ = false;  // the last trial was committed
};

/// By CVODE's backward differentiation formulas. Throws std::runtime_error in a build without
/// SUNDIALS (STILLGRID_SUNDIALS=OFF).
[[nodiscard]] std::unique_ptr<Integrator> make_cvode_integrator(double tolerance_m_s);

}  // namespace stillgrid::dynamics
