#include "sim_server/dynamics/integrator.hpp"

#include "sim_server/dynamics/implicit_euler.hpp"
#include "sim_server/dynamics/newton.hpp"

namespace stillgrid {
namespace {

std::unique_ptr<NonlinearSolver> make_solver(const Method& method) {
  return std::make_unique<NewtonSolver>(method.tolerance_m_s);
}

}  // namespace

void Integrator::commit(World& world, double duration_s) {
  world.nodes = trial_.nodes;
  world.rigid_bodies = trial_.rigid_bodies;
  world.time_s += duration_s;
}

std::unique_ptr<Integrator> make_integrator(const Method& method) {
  return std::make_unique<ImplicitEuler>(make_solver(method));
}

}  // namespace stillgrid
