#include "tests/sim_server/dynamics/stopped_step.hpp"

#include "shared/tools/laboratory/methods/arkode_integrator.hpp"
#include "shared/tools/laboratory/methods/broyden.hpp"
#include "shared/tools/laboratory/methods/kinsol_solver.hpp"

namespace stillgrid::laboratory::stopped_step_test {
namespace {

TEST_CASE("A step of a method of the laboratory is stopped, and taken up again, as the product's",
          "[stopped_step]") {
  dynamics::check_stopped_step({.solver = kBroyden});
  dynamics::check_stopped_step({.solver = kKinsolNewtonKrylov});
  dynamics::check_stopped_step({.integrator = kArkodeDirk});
}

}  // namespace
}  // namespace stillgrid::laboratory::stopped_step_test
