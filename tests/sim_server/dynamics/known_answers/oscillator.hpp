#pragma once

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics {

/// A mass of 0.1 kg on a spring of 1000 N/m, 100 rad/s, pulled by 1 mm.
inline constexpr double kRate_rad_s = 100.0;
[[nodiscard]] inline scene::SceneDescription oscillator(double damping_ratio,
                                                        const scene::Method& method) {
  bodies::BodyDescription body = sim_server::thread(2, {0, 0, 0}, {1, 0, 0}, 0.1, 1000.0, {0});
  sim_server::springs(body).spring_damping_N_s_per_m = 2.0 * damping_ratio * 0.1 * kRate_rad_s;
  scene::SceneDescription scene = sim_server::scene_of({body});
  scene.method = method;
  scene.sleeping = false;
  return scene;
}
inline void pull(Simulation& oscillator) {
  oscillator.world().nodes[1].position_m.x() += 1e-3;
}

/// By which the oscillator's energy grows over steps of as many substeps each.
[[nodiscard]] inline double energy_growth(double damping_ratio, const scene::IntegratorKind& kind,
                                          double substep_s, int steps, int substeps = 1) {
  Simulation simulation(oscillator(damping_ratio, {.integrator = kind, .substeps = substeps}));
  pull(simulation);
  const double before_J = bodies::mechanical_energy_J(simulation.world());
  const auto growth = [&] { return bodies::mechanical_energy_J(simulation.world()) / before_J; };
  for (int i = 0; i < steps && growth() < 1e9; ++i)
    (void)advance(simulation, substeps * substep_s, 1);
  return growth();
}

}  // namespace stillgrid::dynamics
