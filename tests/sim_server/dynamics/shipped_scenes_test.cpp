#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::shipped_scenes_test {
namespace {

scene::SceneDescription shipped(const std::string& name) {
  return scene::load_scene(std::filesystem::path(STILLGRID_SOURCE_DIR) / "sim_server/scene/scenes" /
                           (name + ".toml"));
}

bool is_finite(const bodies::World& world) {
  bool finite = true;
  for (const bodies::Node& node : world.nodes)
    finite = finite && node.position_m.allFinite() && node.velocity_m_s.allFinite();
  for (const bodies::RigidBody& body : world.rigid_bodies)
    finite = finite && body.position_m.allFinite() && body.velocity_m_s.allFinite() &&
             body.orientation.coeffs().allFinite() && body.angular_velocity_rad_s.allFinite();
  return finite;
}

double fastest_m_s(const bodies::World& world) {
  double speed_m_s = 0.0;
  for (const bodies::Node& node : world.nodes)
    speed_m_s = std::max(speed_m_s, node.velocity_m_s.norm());
  for (const bodies::RigidBody& body : world.rigid_bodies)
    speed_m_s =
        std::max(speed_m_s, body.velocity_m_s.norm() +
                                body.bounding_radius_m * body.angular_velocity_rad_s.norm());
  return speed_m_s;
}

/// Looking for contacts anew costs more than a step: the energy is looked at every hundredth of a
/// second.
constexpr double kLook_s = 0.01;

/// A scene left to itself: how far its energy, that of contacts included, ever rose above its
/// lowest, and what it came to.
struct Settled {
  double most_risen_J = 0.0;
  int missed = 0;
  EnergyAccount account;
  double fastest_m_s = 0.0;
  int is_sleeping = 0, bodies = 0;
  bodies::World world;
};

Settled settled(const std::string& name, double duration_s) {
  const scene::SceneDescription scene = shipped(name);
  Simulation simulation(scene);
  simulation.account_energy();
  double lowest_J = simulation.energy_account()->start.total_J();
  Settled result;
  const int steps = std::max(1, static_cast<int>(std::lround(kLook_s / scene.period_s)));
  while (simulation.world().time_s < duration_s) {
    if (!advance(simulation, scene.period_s, steps)) ++result.missed;
    REQUIRE(is_finite(simulation.world()));
    const double now_J = simulation.energy_account()->end.total_J();
    result.most_risen_J = std::max(result.most_risen_J, now_J - lowest_J);
    lowest_J = std::min(lowest_J, now_J);
  }
  result.world = simulation.world();
  result.account = *simulation.energy_account();
  result.fastest_m_s = fastest_m_s(result.world);
  for (const bodies::BodyRange& body : result.world.bodies) {
    const bool is_free = body.rigid >= 0 || body.node_count > 0;
    if (is_free) ++result.bodies;
    if (is_free && body.is_sleeping) ++result.is_sleeping;
  }
  return result;
}

TEST_CASE("Tissue and blocks lose energy, that of contacts included, and come to rest",
          "[shipped_scenes]") {
  const Settled end = settled("tissue_and_blocks", 10.0);
  const double lost_J = end.account.start.total_J() - end.account.end.total_J();

  CHECK(end.missed == 0);
  CHECK(lost_J > 0.05);
  CHECK(end.most_risen_J < 1e-3 * lost_J);
  CHECK(end.fastest_m_s < 1e-3);
  for (const bodies::RigidBody& block : end.world.rigid_bodies) {
    CHECK(block.position_m.z() > -0.1);  // none has sunk into the floor
    CHECK(block.position_m.z() < 0.05);
  }
}

TEST_CASE("Tissue and blocks sleep within half a minute", "[shipped_scenes]") {
  const Settled end = settled("tissue_and_blocks", 30.0);
  CHECK(end.is_sleeping == end.bodies);
}

TEST_CASE("The friction of tissue and blocks takes no more than the scene loses",
          "[shipped_scenes]") {
  const Settled end = settled("tissue_and_blocks", 10.0);
  const double lost_J = end.account.start.total_J() - end.account.end.total_J();
  CHECK(end.account.numerical_J() > -0.01 * lost_J);
}

TEST_CASE("Hanging threads lose energy and settle where they hang", "[shipped_scenes]") {
  const Settled end = settled("threads", 10.0);
  const double lost_J = end.account.start.total_J() - end.account.end.total_J();

  CHECK(end.missed == 0);
  CHECK(lost_J > 1e-5);
  CHECK(end.most_risen_J < 1e-3 * lost_J);
  CHECK(std::abs(end.account.numerical_J()) < 0.01 * lost_J);
  CHECK(end.is_sleeping == end.bodies);
}

TEST_CASE("The soft organ and its rigid cast come to rest, and the organ gives way to the tool",
          "[shipped_scenes]") {
  const scene::SceneDescription scene = shipped("organ");
  Simulation simulation(scene);
  REQUIRE(scene.bodies.size() == 3);
  const double start_J = bodies::mechanical_energy_J(simulation.world());
  CHECK(advance(simulation, scene.period_s, static_cast<int>(4.0 / scene.period_s)));

  const bodies::World& world = simulation.world();
  REQUIRE(is_finite(world));
  CHECK(bodies::mechanical_energy_J(world) < start_J);
  CHECK(fastest_m_s(world) < 0.05);
  for (const bodies::SphereBinding& sphere : world.spheres) {  // on the table, hardly pressed in
    const double low_m = bodies::sphere_motion(world, sphere).position_m.z() - sphere.radius_m;
    CHECK(low_m > -0.018);
  }

  // The tool comes down on the soft organ's thin end and stays.
  const Eigen::Vector3d above_m(-0.018, 0.0, 0.03);
  const std::vector<bodies::Node> before = world.nodes;
  for (int i = 0; i <= 50; ++i) {
    const Eigen::Vector3d at_m = above_m - Eigen::Vector3d(0, 0, std::min(0.03, 0.001 * i));
    const StepReport report = simulation.step(0.02, [&] { return ToolSample{.position_m = at_m}; });
    CHECK(report.solve.converged);
  }
  REQUIRE(is_finite(world));
  double farthest_m = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i)
    farthest_m = std::max(farthest_m, (world.nodes[i].position_m - before[i].position_m).norm());
  CHECK(farthest_m > 0.002);
}

TEST_CASE(
    "The laparoscopy's organ rests on its pinned underside, and its vessel sags between its ends",
    "[shipped_scenes]") {
  const scene::SceneDescription scene = shipped("laparoscopy");
  CHECK(scene.tool.size() == 16);
  Simulation simulation(scene);
  const std::vector<bodies::Node> start = simulation.world().nodes;
  CHECK(advance(simulation, scene.period_s, static_cast<int>(3.0 / scene.period_s)));

  const bodies::World& world = simulation.world();
  REQUIRE(is_finite(world));
  const auto pinned = std::count_if(start.begin(), start.end(),
                                    [](const bodies::Node& node) { return node.pinned; });
  CHECK(pinned > 2 + 10);  // more than the ends of the vessel
  for (std::size_t i = 0; i < start.size(); ++i) {
    const bool is_vessel = start[i].position_m.z() > 0.055;  // it sags, and swings for seconds
    const double moved_m = (world.nodes[i].position_m - start[i].position_m).norm();
    CHECK(moved_m < (is_vessel ? 0.015 : 0.002));
    CHECK(world.nodes[i].velocity_m_s.norm() < (is_vessel ? 0.1 : 1e-3));
  }
}

TEST_CASE("A rod's side that turns about its trocar pushes the organ ahead of it",
          "[shipped_scenes]") {
  const scene::SceneDescription scene = shipped("laparoscopy");
  Simulation simulation(scene);
  const std::vector<bodies::Node> start = simulation.world().nodes;
  const Eigen::Vector3d trocar_m(0.0, 0.0, 0.18);
  constexpr double kDistance_m = 0.08;  // of the handle from the trocar: the tip is near the floor
  for (int i = 0; i <= 100; ++i) {
    const double tilt_rad = 0.4 - 0.003 * i;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(-tilt_rad, Eigen::Vector3d::UnitX()));
    const Eigen::Vector3d handle_m = trocar_m + kDistance_m * (turn * Eigen::Vector3d::UnitZ());
    const std::uint64_t now_ns = static_cast<std::uint64_t>(i + 1) * 20'000'000;
    const StepReport report = simulation.step(0.002, [&] {
      return ToolSample{.time_ns = now_ns, .position_m = handle_m, .orientation = turn};
    });
    CHECK(report.solve.converged);
  }
  const bodies::World& world = simulation.world();
  REQUIRE(is_finite(world));
  double farthest_m = 0.0;
  for (std::size_t i = 0; i < start.size(); ++i)
    farthest_m = std::max(farthest_m, world.nodes[i].position_m.y() - start[i].position_m.y());
  CHECK(farthest_m > 0.002);
}

TEST_CASE("Pillars converge from their first step, and most of them sleep within a second",
          "[shipped_scenes]") {
  const scene::SceneDescription scene = shipped("pillars");
  Simulation simulation(scene);

  CHECK(advance(simulation, scene.period_s, static_cast<int>(1.0 / scene.period_s)));
  CHECK(is_finite(simulation.world()));
  const StepReport report = simulation.step(scene.period_s, no_tool);
  CHECK(report.sleeping_spheres > 18'000);
}

/// Where every node and every rigid body is after a time, by steps that divide the scene's.
std::vector<Eigen::Vector3d> places_m(const scene::SceneDescription& scene, int steps,
                                      int division) {
  Simulation simulation(scene);
  (void)advance(simulation, scene.period_s / division, steps * division);
  std::vector<Eigen::Vector3d> places;
  for (const bodies::Node& node : simulation.world().nodes) places.push_back(node.position_m);
  for (const bodies::RigidBody& body : simulation.world().rigid_bodies)
    places.push_back(body.position_m);
  return places;
}

TEST_CASE("Every shipped scene comes to where velocity Verlet at 4 kHz leads it",
          "[shipped_scenes]") {
  // By implicit Euler at 250 Hz a block of tissue_and_blocks lay 11.5 mm off.
  const std::string name =
      GENERATE("block_pinched", "cloth_held_by_two", "laparoscopy", "moving_sphere", "organ",
               "pendulum_chain", "sewn_ball", "threads", "tissue_and_blocks");
  CAPTURE(name);
  scene::SceneDescription scene = shipped(name);
  const int steps = static_cast<int>(std::lround(4.0 / scene.period_s));
  const std::vector<Eigen::Vector3d> own = places_m(scene, steps, 1);
  scene.method = {.integrator = scene::IntegratorKind::kVelocityVerlet};
  const std::vector<Eigen::Vector3d> truth =
      places_m(scene, steps, static_cast<int>(std::lround(4000.0 * scene.period_s)));
  for (std::size_t i = 0; i < own.size(); ++i) CHECK((own[i] - truth[i]).norm() < 1e-3);
}

TEST_CASE("A thousand steps of each shipped scene stay finite", "[shipped_scenes]") {
  const scene::SceneDescription scene = shipped(GENERATE("moving_sphere", "wall"));
  Simulation simulation(scene);

  CHECK(advance(simulation, scene.period_s, 1000));
  CHECK(is_finite(simulation.world()));
}

}  // namespace
}  // namespace stillgrid::dynamics::shipped_scenes_test
