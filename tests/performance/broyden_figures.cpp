// Where Broyden's method fails: prints docs/charts/broyden_iterations.csv.
#include <cmath>
#include <cstdio>

#include "shared/tools/laboratory/methods/broyden.hpp"
#include "shared/tools/laboratory/methods/kinsol_solver.hpp"
#include "tests/sim_server/dynamics/hanging_chain.hpp"

namespace stillgrid {
namespace {

constexpr double kTolerance_m_s = 1e-10;

void print_solver(const char* name, NonlinearSolver& solver) {
  for (int i = -4; i <= 16; ++i) {  // from 0.1 to 1e4
    const double stiffness = std::pow(10.0, 0.25 * i);
    const ChainSolves chain = solve_hanging_chain(solver, stiffness, kTolerance_m_s);
    std::printf("chain,%s,%.6g,%.6g,%d\n", name, stiffness, chain.mean_iterations, chain.failures);
    const SolveReport onset = solve_contact_onset(solver, stiffness, 500);
    std::printf("onset,%s,%.6g,%d,%d\n", name, stiffness, onset.iterations,
                onset.converged ? 0 : 1);
  }
}

}  // namespace
}  // namespace stillgrid

int main() {
  using namespace stillgrid;
  BroydenSolver from_mass(BroydenStart::kMass, kTolerance_m_s);
  BroydenSolver from_jacobian(BroydenStart::kJacobian, kTolerance_m_s);
  NewtonSolver newton(SolverKind::kNewton, kTolerance_m_s);
  KinsolSolver krylov(KinsolStrategy::kNewtonKrylov, kTolerance_m_s);
  KinsolSolver anderson(KinsolStrategy::kAnderson, kTolerance_m_s);
  std::printf("scene,solver,k_h2_per_m,iterations,failures\n");
  print_solver("broyden_mass", from_mass);
  print_solver("broyden", from_jacobian);
  print_solver("newton", newton);
  print_solver("kinsol_newton_krylov", krylov);
  print_solver("kinsol_anderson", anderson);
}
