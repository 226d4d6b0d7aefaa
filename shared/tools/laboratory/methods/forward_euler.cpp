#include "shared/tools/laboratory/methods/forward_euler.hpp"

namespace stillgrid::laboratory {

void ForwardEuler::apply(const bodies::World& world, double substep_s) {
  drift(world, substep_s);
  kick(world, substep_s);
}

std::unique_ptr<dynamics::Integrator> make_forward_euler(const scene::Method& method) {
  return std::make_unique<ForwardEuler>(method);
}

}  // namespace stillgrid::laboratory
