#include <cvode/cvode.h>
#include <cvode/cvode_ls.h>

#include "sim_server/dynamics/integrators/sundials_stepper.hpp"

namespace stillgrid::dynamics {
namespace {

class CvodeStepper : public SundialsStepper {
 public:
  explicit CvodeStepper(const SundialsProblem& problem)
      : memory_(sun_checked(CVodeCreate(CV_BDF, problem.context))), state_(problem.state) {
    int failures = CVodeSetUserData(memory_.get(), problem.data);
#if SUNDIALS_VERSION_MAJOR < 7
    failures |= CVodeSetErrHandlerFn(memory_.get(), ignore_message, nullptr);
#endif
    failures |= CVodeInit(memory_.get(), problem.slope, 0.0, state_);
    failures |=
        CVodeSVtolerances(memory_.get(), problem.relative_tolerance, problem.absolute_tolerances);
    failures |= CVodeSetLinearSolver(memory_.get(), problem.linear, nullptr);
    if (failures != 0) throw std::bad_alloc();
  }

  bool evolve(double end_s, double stop_s, long most_steps, double& now_s) override {
    CVodeSetMaxNumSteps(memory_.get(), most_steps);
    CVodeSetStopTime(memory_.get(), stop_s);
    return CVode(memory_.get(), end_s, state_, &now_s, CV_NORMAL) >= 0;
  }
  [[nodiscard]] double gamma_s() const override {
    double gamma_s = 0.0;
    CVodeGetCurrentGamma(memory_.get(), &gamma_s);
    return gamma_s;
  }
  [[nodiscard]] long steps_taken() const override {
    long steps = 0;
    CVodeGetNumSteps(memory_.get(), &steps);
    return steps;
  }

 private:
  SunMemory<CVodeFree> memory_;
  N_Vector state_;
};

}  // namespace

std::unique_ptr<SundialsStepper> make_cvode_stepper(const SundialsProblem& problem) {
  return std::make_unique<CvodeStepper>(problem);
}

}  // namespace stillgrid::dynamics
