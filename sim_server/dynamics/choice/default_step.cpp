#include "sim_server/dynamics/choice/default_step.hpp"

#include "sim_server/dynamics/choice/predicted_cost.hpp"

namespace stillgrid::dynamics {

void settle_step(scene::SceneDescription& scene, const bodies::World& world) {
  constexpr double kPeriod_s = 1e-3, kBudget_ms = 0.25;
  constexpr double kTouchingPerSphere = 1.0 / 12.0;
  if (scene.names_step) return;
  const scene::Method verlet{.integrator = scene::IntegratorKind::kVelocityVerlet};
  const SceneLoad load = load_of(world);
  const StepWork work{.iterations = static_cast<double>(taken_substeps(load, kPeriod_s)),
                      .contacts = kTouchingPerSphere * load.spheres};
  if (cost_ms(load, verlet, work) > kBudget_ms) return;
  scene.period_s = kPeriod_s;
  scene.method = verlet;
}

}  // namespace stillgrid::dynamics
