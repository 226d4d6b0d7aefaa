#include "shared/tools/laboratory/methods/kinsol_solver.hpp"

#include <kinsol/kinsol.h>
#include <kinsol/kinsol_ls.h>
#include <sunlinsol/sunlinsol_spgmr.h>

#include <Eigen/LU>
#include <cmath>

#include "sim_server/dynamics/integrators/sundials_memory.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr int kKrylovVectors = 30, kKrylovRestarts = 3;
constexpr long kAndersonVectors = 5;
constexpr double kLongestStep = 1e6;  // m/s, of all unknowns together: the line search bounds it

void invert_blocks(const Eigen::Matrix3Xd& blocks, Eigen::Matrix3Xd& inverses) {
  inverses.resize(3, blocks.cols());
  for (Eigen::Index i = 0; i < blocks.cols(); i += 3)
    inverses.middleCols<3>(i) = blocks.middleCols<3>(i).inverse();
}

void multiply_blocks(const Eigen::Matrix3Xd& blocks, Eigen::Map<Eigen::VectorXd> x) {
  for (Eigen::Index i = 0; i < blocks.cols(); i += 3)
    x.segment<3>(i) = (blocks.middleCols<3>(i) * x.segment<3>(i)).eval();
}

}  // namespace

/// KINSOL's memory for one size of system, and what its callbacks share.
struct KinsolSolver::Run {
  Run(KinsolStrategy strategy, double tolerance, Eigen::Index size);

  int evaluate(N_Vector at, N_Vector result);
  int prepare(N_Vector at);
  void load(N_Vector at);

  // Freed in the reverse order: the context last.
  dynamics::SunContext context = dynamics::make_sun_context();
  dynamics::SunVector unknowns, unknown_scale, residual_scale;
  dynamics::SunLinearSolver krylov;
  dynamics::SunMemory<KINFree> memory;

  KinsolStrategy strategy;
  double tolerance;
  dynamics::NonlinearSystem* system = nullptr;
  dynamics::Budget clock;  // deadline and stop alone
  Eigen::VectorXd u, residual, best, product;
  Eigen::Matrix3Xd inverse_blocks;
  double least_error = 0.0;
  std::exception_ptr thrown;
};

KinsolSolver::Run::Run(KinsolStrategy taken_strategy, double rms_tolerance, Eigen::Index size)
    : unknowns(dynamics::make_sun_vector(size, context.get())),
      unknown_scale(dynamics::make_sun_vector(size, context.get())),
      residual_scale(dynamics::make_sun_vector(size, context.get())),
      memory(dynamics::sun_checked(KINCreate(context.get()))),
      strategy(taken_strategy),
      tolerance(rms_tolerance) {
  void* const kinsol = memory.get();
  const auto residual_at = [](N_Vector at, N_Vector result, void* data) {
    Run& run = *static_cast<Run*>(data);
    return dynamics::keep_exception(run.thrown, [&] { return run.evaluate(at, result); });
  };
#if SUNDIALS_VERSION_MAJOR < 7
  KINSetErrHandlerFn(kinsol, dynamics::ignore_message, nullptr);
#endif
  KINSetUserData(kinsol, this);
  if (strategy == KinsolStrategy::kAnderson) KINSetMAA(kinsol, kAndersonVectors);
  if (KINInit(kinsol, residual_at, unknowns.get()) != KIN_SUCCESS) throw std::bad_alloc();
  // The callback stops at the tolerance; KINSOL's own tests are of other norms.
  KINSetFuncNormTol(kinsol, 1e-300);
  KINSetScaledStepTol(kinsol, 1e-14);
  KINSetMaxNewtonStep(kinsol, kLongestStep);
  if (strategy == KinsolStrategy::kAnderson) return;

  krylov.reset(dynamics::sun_checked(
      SUNLinSol_SPGMR(unknowns.get(), SUN_PREC_RIGHT, kKrylovVectors, context.get())));
  SUNLinSol_SPGMRSetMaxRestarts(krylov.get(), kKrylovRestarts);
  KINSetLinearSolver(kinsol, krylov.get(), nullptr);
  KINSetMaxSetupCalls(kinsol, 1);
  KINSetJacTimesVecFn(kinsol,
                      [](N_Vector x, N_Vector result, N_Vector, sunbooleantype*, void* data) {
                        Run& run = *static_cast<Run*>(data);
                        return dynamics::keep_exception(run.thrown, [&] {
                          run.u = dynamics::values_of(x);
                          run.system->multiply(run.u, run.product);
                          dynamics::values_of(result) = run.product;
                          return run.clock.spent() ? dynamics::kSunStop : dynamics::kSunDone;
                        });
                      });
  KINSetPreconditioner(
      kinsol,
      [](N_Vector at, N_Vector, N_Vector, N_Vector, void* data) {
        Run& run = *static_cast<Run*>(data);
        return dynamics::keep_exception(run.thrown, [&] { return run.prepare(at); });
      },
      [](N_Vector, N_Vector, N_Vector, N_Vector, N_Vector x, void* data) {
        multiply_blocks(static_cast<Run*>(data)->inverse_blocks, dynamics::values_of(x));
        return dynamics::kSunDone;
      });
}

void KinsolSolver::Run::load(N_Vector at) {
  u = dynamics::values_of(at);
  system->residual(u, residual);
}

/// r(u), or the map whose fixed point is sought. Done is: good enough.
int KinsolSolver::Run::evaluate(N_Vector at, N_Vector result) {
  load(at);
  const double error = dynamics::scaled_rms(*system, residual);
  if (!std::isfinite(error)) return dynamics::kSunRetry;
  if (error < least_error) {
    least_error = error;
    best = u;
  }
  if (error <= tolerance || clock.spent()) return dynamics::kSunStop;
  dynamics::values_of(result) = residual;
  if (strategy == KinsolStrategy::kAnderson) {
    multiply_blocks(inverse_blocks, dynamics::values_of(result));
    dynamics::values_of(result) = u - dynamics::values_of(result);
  }
  return dynamics::kSunDone;
}

int KinsolSolver::Run::prepare(N_Vector at) {
  load(at);  // the line search may have looked further last
  system->linearise(dynamics::JacobianKind::kExact);
  invert_blocks(system->block_diagonal(), inverse_blocks);
  return dynamics::kSunDone;
}

KinsolSolver::KinsolSolver(KinsolStrategy strategy, double tolerance)
    : strategy_(strategy), tolerance_(tolerance) {}
KinsolSolver::~KinsolSolver() = default;

dynamics::SolveReport KinsolSolver::solve(dynamics::NonlinearSystem& system, Eigen::VectorXd& u,
                                          dynamics::Budget& budget) {
  Eigen::VectorXd residual(u.size());
  system.residual(u, residual);
  dynamics::SolveReport report;
  report.residual = dynamics::scaled_rms(system, residual);
  report.converged = report.residual <= tolerance_;
  if (report.converged || budget.spent() || !std::isfinite(report.residual)) return report;

  if (!run_ || run_->best.size() != u.size())
    run_ = std::make_unique<Run>(strategy_, tolerance_, u.size());
  Run& run = *run_;
  run.system = &system;
  run.clock.deadline = budget.deadline;
  run.clock.stop = budget.stop;
  run.residual.resize(u.size());
  run.product.resize(u.size());
  run.best = u;
  run.least_error = report.residual;
  run.thrown = nullptr;
  dynamics::values_of(run.unknowns.get()) = u;
  dynamics::values_of(run.residual_scale.get()) = system.residual_scale();
  dynamics::values_of(run.unknown_scale.get()) =
      system.residual_scale().cwiseProduct(system.mass_diagonal());
  const bool anderson = strategy_ == KinsolStrategy::kAnderson;
  if (anderson) {
    system.linearise(dynamics::JacobianKind::kDefinite);
    invert_blocks(system.block_diagonal(), run.inverse_blocks);
  }
  KINSetNumMaxIters(run.memory.get(), budget.iterations);
  KINSol(run.memory.get(), run.unknowns.get(), anderson ? KIN_FP : KIN_LINESEARCH,
         run.unknown_scale.get(), anderson ? run.unknown_scale.get() : run.residual_scale.get());
  if (run.thrown) std::rethrow_exception(run.thrown);

  long iterations = 0;
  KINGetNumNonlinSolvIters(run.memory.get(), &iterations);
  report.iterations = static_cast<int>(iterations);
  budget.iterations -= report.iterations;
  u = run.best;
  system.residual(u, run.residual);
  report.residual = run.least_error;
  report.converged = report.residual <= tolerance_;
  return report;
}

std::unique_ptr<dynamics::NonlinearSolver> make_kinsol_newton_krylov(double tolerance) {
  return std::make_unique<KinsolSolver>(KinsolStrategy::kNewtonKrylov, tolerance);
}

std::unique_ptr<dynamics::NonlinearSolver> make_kinsol_anderson(double tolerance) {
  return std::make_unique<KinsolSolver>(KinsolStrategy::kAnderson, tolerance);
}

}  // namespace stillgrid::laboratory
