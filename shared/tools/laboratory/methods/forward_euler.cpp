#include "shared/tools/laboratory/methods/forward_euler.hpp"

namespace stillgrid::laboratory {

void ForwardEuler::apply(const dynamics::Move& move, const bodies::World& world, double step_s) {
  dynamics::ExplicitState& moved = state();
  dynamics::move_nodes({.drift_s = move.drift_s}, world.gravity_m_s2, moved);
  drift(move.drift_s);
  dynamics::move_nodes({.kick_s = move.kick_s}, world.gravity_m_s2, moved);
  kick(world, move.kick_s);
  resist(move.kick_s, step_s, 0.0);  // what it changes of velocities moves nothing before the next
}

std::unique_ptr<dynamics::Integrator> make_forward_euler(const scene::Method& method) {
  return std::make_unique<ForwardEuler>(method);
}

}  // namespace stillgrid::laboratory
