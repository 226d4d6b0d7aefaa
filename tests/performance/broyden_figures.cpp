// Where Broyden's method fails: prints docs/charts/broyden_iterations.csv.
#include <cmath>
#include <cstdio>

#include "shared/tools/laboratory/methods/broyden.hpp"
#include "shared/tools/laboratory/methods/kinsol_solver.hpp"
#include "tests/sim_server/dynamics/hanging_chain.hpp"

namespace stillgrid::performance {
namespace {

constexpr double kTolerance_m_s = 1e-10;

void print_solver(const char* name, dynamics::NonlinearSolver& solver) {
  for (int i = -4; i <= 16; ++i) {  // from 0.1 to 1e4
    const double stiffness = std::pow(10.0, 0.25 * i);
    const dynamics::ChainSolves chain =
        dynamics::solve_hanging_chain(solver, stiffness, kTolerance_m_s);
    std::printf("chain,%s,%.6g,%.6g,%d\n", name, stiffness, chain.mean_iterations, chain.failures);
    const dynamics::SolveReport onset = dynamics::solve_contact_onset(solver, stiffness, 500);
    std::printf("onset,%s,%.6g,%d,%d\n", name, stiffness, onset.iterations,
                onset.converged ? 0 : 1);
  }
}

int program_main() {
  laboratory::BroydenSolver from_mass(laboratory::BroydenStart::kMass, kTolerance_m_s);
  laboratory::BroydenSolver from_jacobian(laboratory::BroydenStart::kJacobian, kTolerance_m_s);
  dynamics::NewtonSolver newton(scene::SolverKind::kNewton, kTolerance_m_s);
  laboratory::KinsolSolver krylov(laboratory::KinsolStrategy::kNewtonKrylov, kTolerance_m_s);
  laboratory::KinsolSolver anderson(laboratory::KinsolStrategy::kAnderson, kTolerance_m_s);
  std::printf("scene,solver,k_h2_per_m,iterations,failures\n");
  print_solver("broyden_mass", from_mass);
  print_solver("broyden", from_jacobian);
  print_solver("newton", newton);
  print_solver("kinsol_newton_krylov", krylov);
  print_solver("kinsol_anderson", anderson);
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main() {
  return stillgrid::performance::program_main();
}
