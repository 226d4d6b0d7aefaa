#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "sim_server/scene/scene_file.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid {
namespace {

SceneDescription shipped(const std::string& name) {
  return load_scene(std::filesystem::path(STILLGRID_SOURCE_DIR) / "sim_server/scene/scenes" /
                    (name + ".toml"));
}

bool is_finite(const World& world) {
  bool finite = true;
  for (const Node& node : world.nodes)
    finite = finite && node.position_m.allFinite() && node.velocity_m_s.allFinite();
  for (const RigidBody& body : world.rigid_bodies)
    finite = finite && body.position_m.allFinite() && body.velocity_m_s.allFinite() &&
             body.orientation.coeffs().allFinite() && body.angular_velocity_rad_s.allFinite();
  return finite;
}

double fastest_m_s(const World& world) {
  double speed_m_s = 0.0;
  for (const Node& node : world.nodes) speed_m_s = std::max(speed_m_s, node.velocity_m_s.norm());
  for (const RigidBody& body : world.rigid_bodies)
    speed_m_s = std::max(
        speed_m_s, body.velocity_m_s.norm() + body.reach_m * body.angular_velocity_rad_s.norm());
  return speed_m_s;
}

TEST_CASE("Tissue and blocks lose energy step by step and come to rest above the floor",
          "[shipped_scenes]") {
  const SceneDescription scene = shipped("tissue_and_blocks");
  Simulation simulation(scene);
  const double start_J = mechanical_energy_J(simulation.world());
  double highest_J = start_J;
  int missed = 0;
  for (int i = 0; i < static_cast<int>(3.0 / scene.period_s); ++i) {
    if (!advance(simulation, scene.period_s, 1)) ++missed;
    REQUIRE(is_finite(simulation.world()));
    highest_J = std::max(highest_J, mechanical_energy_J(simulation.world()));
  }

  CHECK(missed == 0);
  CHECK(highest_J <= start_J + 1e-9);
  CHECK(fastest_m_s(simulation.world()) < 0.02);
  for (const RigidBody& block : simulation.world().rigid_bodies) {
    CHECK(block.position_m.z() > -0.1);  // none has sunk into the floor
    CHECK(block.position_m.z() < 0.05);
  }
}

TEST_CASE("Hanging threads settle where they hang", "[shipped_scenes]") {
  const SceneDescription scene = shipped("threads");
  Simulation simulation(scene);
  const double start_J = mechanical_energy_J(simulation.world());
  CHECK(advance(simulation, scene.period_s, static_cast<int>(3.0 / scene.period_s)));

  REQUIRE(is_finite(simulation.world()));
  CHECK(mechanical_energy_J(simulation.world()) <= start_J);
  CHECK(fastest_m_s(simulation.world()) < 1e-3);
}

TEST_CASE("A thousand steps of each shipped scene stay finite", "[shipped_scenes]") {
  const SceneDescription scene = shipped(GENERATE("moving_sphere", "wall"));
  Simulation simulation(scene);

  CHECK(advance(simulation, scene.period_s, 1000));
  CHECK(is_finite(simulation.world()));
}

}  // namespace
}  // namespace stillgrid
