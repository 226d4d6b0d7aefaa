#include "sim_server/dynamics/choice/default_step.hpp"

#include "sim_server/dynamics/choice/predicted_cost.hpp"

namespace stillgrid::dynamics {

void settle_step(scene::SceneDescription& scene, const bodies::World& world) {
  constexpr double kPeriod_s = 1e-3, kBudget_ms = 0.25;
  const scene::Method verlet{.integrator = scene::IntegratorKind::kVelocityVerlet};
  if (scene.names_step || predicted_ms(load_of(world), verlet, kPeriod_s) > kBudget_ms) return;
  scene.period_s = kPeriod_s;
  scene.method = verlet;
}

}  // namespace stillgrid::dynamics
