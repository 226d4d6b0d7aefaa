// Where Broyden's method fails: prints docs/charts/broyden_iterations.csv.
#include <cmath>
#include <cstdio>

#include "tests/laboratory/methods/broyden.hpp"
#include "tests/shared/dynamics/hanging_chain.hpp"

namespace stillgrid::performance {
namespace {

constexpr double kTolerance_m_s = 1e-10;

template <class Solver, class... Options>
void print_solver(const char* name, Options... onset_options) {
  for (int i = -4; i <= 16; ++i) {  // from 0.1 to 1e4
    const double stiffness = std::pow(10.0, 0.25 * i);
    const dynamics::ChainSolves chain =
        dynamics::solve_hanging_chain<Solver>(stiffness, kTolerance_m_s);
    std::printf("chain,%s,%.6g,%.6g,%d\n", name, stiffness, chain.mean_iterations, chain.failures);
    const dynamics::SolveFigures onset =
        dynamics::solve_contact_onset<Solver>(stiffness, kTolerance_m_s, onset_options...);
    std::printf("onset,%s,%.6g,%d,%d\n", name, stiffness, onset.iterations,
                onset.converged ? 0 : 1);
  }
}

int program_main() {
  std::printf("scene,solver,k_h2_per_m,iterations,failures\n");
  print_solver<laboratory::BroydenStep>("broyden", 500);
  print_solver<dynamics::ImplicitStep>("newton");
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main() {
  return stillgrid::performance::program_main();
}
