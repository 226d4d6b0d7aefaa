#pragma once

#include <memory>

#include "sim_server/dynamics/integrators/sundials_memory.hpp"

// For the .cpp files that use SUNDIALS only.
namespace stillgrid::dynamics {

/// y' = slope(t, y), as SUNDIALS' integrators take it.
struct SundialsProblem {
  SUNContext context;
  N_Vector state;  // at time 0; steps move it on
  int (*slope)(sunrealtype at_s, N_Vector y, N_Vector result, void* data);
  void* data;
  double relative_tolerance;
  N_Vector absolute_tolerances;
  SUNLinearSolver linear;  // of (1 - gamma J) x = b
};

/// One of SUNDIALS' integrators, begun at time 0. The problem outlives it.
class SundialsStepper {
 public:
  SundialsStepper() = default;
  virtual ~SundialsStepper() = default;
  SundialsStepper(const SundialsStepper&) = delete;
  SundialsStepper& operator=(const SundialsStepper&) = delete;
  SundialsStepper(SundialsStepper&&) = delete;
  SundialsStepper& operator=(SundialsStepper&&) = delete;

  /// Moves the state on to end_s, by steps that do not go beyond stop_s; now_s: where the state is
  /// then. False if it failed on the way.
  virtual bool evolve(double end_s, double stop_s, long most_steps, double& now_s) = 0;
  /// Of the linear systems at present.
  [[nodiscard]] virtual double gamma_s() const = 0;
  [[nodiscard]] virtual long steps_taken() const = 0;
};

/// CVODE's backward differentiation formulas of order 1 to 5. Throws std::bad_alloc.
[[nodiscard]] std::unique_ptr<SundialsStepper> make_cvode_stepper(const SundialsProblem& problem);

}  // namespace stillgrid::dynamics
