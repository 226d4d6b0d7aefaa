#include <stdexcept>
#include <string>

#include "sim_server/dynamics/integrators/sundials_integrator.hpp"
#include "sim_server/dynamics/solvers/kinsol_solver.hpp"

namespace stillgrid {
namespace {

[[noreturn]] void refuse(std::string_view method) {
  throw std::runtime_error(std::string(method) + ": this build is without SUNDIALS");
}

}  // namespace

std::unique_ptr<NonlinearSolver> make_kinsol_solver(SolverKind kind, double /*tolerance*/) {
  refuse(name_of(kind));
}

std::unique_ptr<Integrator> make_sundials_integrator(IntegratorKind kind,
                                                     double /*tolerance_m_s*/) {
  refuse(name_of(kind));
}

}  // namespace stillgrid
