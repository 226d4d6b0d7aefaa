#include "shared/tools/laboratory/methods/arkode_integrator.hpp"

#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_ls.h>

#include "sim_server/dynamics/integrators/sundials_integrator.hpp"
#include "sim_server/dynamics/integrators/sundials_stepper.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr int kOrder = 4;

class ArkodeStepper : public dynamics::SundialsStepper {
 public:
  explicit ArkodeStepper(const dynamics::SundialsProblem& problem)
      : memory_(dynamics::sun_checked(
            ARKStepCreate(nullptr, problem.slope, 0.0, problem.state, problem.context))),
        state_(problem.state) {
    int failures = ARKStepSetUserData(memory_.get(), problem.data);
#if SUNDIALS_VERSION_MAJOR < 7
    failures |= ARKStepSetErrHandlerFn(memory_.get(), dynamics::ignore_message, nullptr);
#endif
    failures |= ARKStepSetOrder(memory_.get(), kOrder);
    failures |=
        ARKStepSVtolerances(memory_.get(), problem.relative_tolerance, problem.absolute_tolerances);
    failures |= ARKStepSetLinearSolver(memory_.get(), problem.linear, nullptr);
    if (failures != 0) throw std::bad_alloc();
  }

  bool evolve(double end_s, double stop_s, long most_steps, double& now_s) override {
    ARKStepSetMaxNumSteps(memory_.get(), most_steps);
    ARKStepSetStopTime(memory_.get(), stop_s);
    return ARKStepEvolve(memory_.get(), end_s, state_, &now_s, ARK_NORMAL) >= 0;
  }
  [[nodiscard]] double gamma_s() const override {
    double gamma_s = 0.0;
    ARKStepGetCurrentGamma(memory_.get(), &gamma_s);
    return gamma_s;
  }
  [[nodiscard]] long steps_taken() const override {
    long steps = 0;
    ARKStepGetNumSteps(memory_.get(), &steps);
    return steps;
  }

 private:
  dynamics::SunMemory<ARKStepFree> memory_;
  N_Vector state_;
};

std::unique_ptr<dynamics::SundialsStepper> make_stepper(const dynamics::SundialsProblem& problem) {
  return std::make_unique<ArkodeStepper>(problem);
}

}  // namespace

std::unique_ptr<dynamics::Integrator> make_arkode_dirk(const scene::Method& method) {
  return std::make_unique<dynamics::SundialsIntegrator>(make_stepper, method.tolerance_m_s);
}

}  // namespace stillgrid::laboratory
