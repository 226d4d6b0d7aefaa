// Where Broyden's method fails: prints docs/charts/broyden_iterations.csv.
#include <cmath>
#include <cstdio>

#include "tests/laboratory/methods/broyden.hpp"
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
  laboratory::BroydenSolver broyden(kTolerance_m_s);
  dynamics::NewtonSolver newton(kTolerance_m_s);
  std::printf("scene,solver,k_h2_per_m,iterations,failures\n");
  print_solver("broyden", broyden);
  print_solver("newton", newton);
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main() {
  return stillgrid::performance::program_main();
}
