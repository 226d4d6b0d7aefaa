#pragma once

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics {

/// A mass of 0.1 kg on a spring of 1000 N/m, 100 rad/s, pulled by 1 mm.
inline constexpr double kRate_rad_s = 100.0;
[[nodiscard]] inline bodies::World oscillator(double damping_ratio) {
  bodies::BodyDescription body = sim_server::thread(2, {0, 0, 0}, {1, 0, 0}, 0.1, 1000.0, {0});
  sim_server::springs(body).spring_damping_N_s_per_m = 2.0 * damping_ratio * 0.1 * kRate_rad_s;
  bodies::World world = scene::build_world(sim_server::scene_of({body}));
  world.nodes[1].position_m.x() += 1e-3;
  return world;
}

/// Steps without contacts.
inline void run(bodies::World& world, const scene::Method& method, double step_s, int steps) {
  const std::unique_ptr<Integrator> integrator = make_integrator(method);
  Budget budget;
  for (int i = 0; i < steps; ++i) {
    (void)integrator->advance(world, {}, step_s, budget);
    integrator->commit(world, step_s);
  }
}

/// By which the oscillator's energy grows over steps of as many substeps each.
[[nodiscard]] inline double energy_growth(double damping_ratio, const scene::IntegratorKind& kind,
                                          double substep_s, int steps, int substeps = 1) {
  bodies::World world = oscillator(damping_ratio);
  const double before_J = bodies::mechanical_energy_J(world);
  run(world, {.integrator = kind, .substeps = substeps}, substeps * substep_s, steps);
  return bodies::mechanical_energy_J(world) / before_J;
}

}  // namespace stillgrid::dynamics
