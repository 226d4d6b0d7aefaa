#pragma once

#include <atomic>
#include <catch2/catch.hpp>

#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics {

/// A hanging sheet by a method.
[[nodiscard]] inline scene::SceneDescription hanging_sheet(const scene::Method& method, int side) {
  bodies::BodyDescription body = sim_server::sheet({side, side}, 0.01, 1e-4, 20.0);
  sim_server::shear_stiffness_N_per_m(body) = 10.0;
  sim_server::springs(body).bend_stiffness_N_per_m = 2.0;
  sim_server::springs(body).pinned_nodes = {0, side - 1};
  scene::SceneDescription scene =
      sim_server::scene_of({body}, sim_server::material_of(100.0), {0, 0, -9.81});
  scene.method = method;
  return scene;
}

[[nodiscard]] inline bool same_nodes(const bodies::World& a, const bodies::World& b) {
  for (std::size_t i = 0; i < a.nodes.size(); ++i)
    if (a.nodes[i].position_m != b.nodes[i].position_m ||
        a.nodes[i].velocity_m_s != b.nodes[i].velocity_m_s)
      return false;
  return a.time_s == b.time_s;
}

/// A step that is stopped leaves the world where it was, and the next takes it up again.
inline void check_stopped_step(const scene::Method& method) {
  INFO(scene::describe(method));
  const scene::SceneDescription scene = hanging_sheet(method, 50);
  Simulation simulation(scene);
  const bodies::World before = simulation.world();
  std::atomic<bool> stop = false;
  const StepReport report =
      simulation.step(0.01,
                      [&] {
                        stop = true;  // after the contacts were found, before anything is solved
                        return std::nullopt;
                      },
                      {.stop = &stop});
  CHECK(report.stopped);
  CHECK(report.solve.iterations <= 1);
  CHECK(same_nodes(simulation.world(), before));
  if (method.substeps > 1) return;  // its million substeps are of no interest

  stop = false;
  CHECK_FALSE(simulation.step(0.01, [] { return std::nullopt; }, {.stop = &stop}).stopped);
  Simulation fresh(scene);
  (void)fresh.step(0.01, [] { return std::nullopt; });
  CHECK(same_nodes(simulation.world(), fresh.world()));
}

}  // namespace stillgrid::dynamics
