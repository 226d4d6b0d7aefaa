#include "sim_server/dynamics/integrators/integrator.hpp"

#include <stdexcept>

#include "sim_server/dynamics/integrators/sundials_integrator.hpp"

namespace stillgrid::dynamics {
void Integrator::commit(bodies::World& world, double duration_s) {
  world.nodes = trial_.nodes;
  world.rigid_bodies = trial_.rigid_bodies;
  world.time_s += duration_s;
}

std::unique_ptr<Integrator> make_integrator(const scene::Method& method) {
  if (method.integrator.make != nullptr) return method.integrator.make(method);
  if (scene::is_by_engine(method.integrator))
    throw std::invalid_argument("expected a method that the engine does not have");
  return make_cvode_integrator(method.tolerance_m_s);
}

}  // namespace stillgrid::dynamics
