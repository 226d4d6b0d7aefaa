// What joints are for the rest of a simulation: building, sleep, contacts.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "sim_server/bodies/joints.hpp"
#include "sim_server/dynamics/choice/counted_work.hpp"
#include "sim_server/dynamics/choice/memory_need.hpp"
#include "tests/sim_server/dynamics/joined.hpp"

namespace stillgrid::dynamics::joined_bodies_test {
namespace {

int count_sleeping(const Simulation& simulation) {
  return static_cast<int>(
      std::ranges::count(simulation.world().bodies, true, &bodies::BodyRange::is_sleeping));
}

TEST_CASE("An end on a body of nodes is the nearest one, and the other end is there too",
          "[joints]") {
  bodies::BodyDescription box = link({0.1, 0, 0}, {0.04, 0.04, 0.04}, 0.1);
  box.orientation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 2).normalized());
  const bodies::World world = scene::build_world(joined_scene(
      {box, sim_server::thread(5, {0, 0, 0}, {0.08, 0, 0}, 0.01, 100.0),
       sim_server::thread(5, {0, 0.05, 0}, {0.08, 0.05, 0}, 0.01, 100.0)},
      {joint(0, 1, {{0.083, 0.002, 0.0}}, 50.0, 1.0), joint(1, 2, {{0.01, 0.02, 0.0}}, 60.0),
       joint(0, -1, {{0.12, 0.01, 0.0}}, 70.0)}));

  REQUIRE(world.joints.size() == 3);
  CHECK(world.joints[0].a.node == 4);
  CHECK(world.joints[0].b.rigid == 0);
  CHECK(world.joints[0].rest_length_m == 0.0);
  CHECK(world.joints[1].a.node + world.joints[1].b.node == 5);  // 0 and 5, their first
  CHECK(world.joints[1].rest_length_m == Approx(0.05));
  for (const bodies::Joint& own : world.joints)
    CHECK(bodies::joint_energy_J(own, world.nodes, world.rigid_bodies) < 1e-25);
  CHECK_FALSE(bodies::may_collide(world, 0, 1));
  CHECK_FALSE(bodies::may_collide(world, 2, 1));
  CHECK(bodies::may_collide(world, 0, 2));
}

TEST_CASE("Joined bodies overlap without a contact unless they are to collide", "[joints]") {
  const bool collide = GENERATE(false, true);
  const bool is_static = GENERATE(false, true);
  bodies::BodyDescription other = link({0.015, 0, 0}, {0.02, 0.02, 0.02}, 0.1);
  if (is_static) other.motion = bodies::Motion::kStatic;
  scene::SceneDescription scene =
      joined_scene({sim_server::sphere({0, 0, 0}, 0.015, 0.1), other},
                   {joint(0, 1, {{0.01, 0, 0}}, 500.0, 1.0)}, 0.0, sim_server::material_of(1000.0));
  scene.joints[0].collide = collide;
  Simulation simulation(scene);
  const StepReport report = simulation.step(0.005, no_tool);
  CHECK((report.contacts > 0) == collide);
}

TEST_CASE("What hangs together sleeps together, and a body that is led keeps it awake",
          "[joints]") {
  const double speed_m_s = GENERATE(0.0, 1e-4);
  bodies::BodyDescription hand = link({0, 0, 0.0}, {0.02, 0.02, 0.02}, 0.0);
  hand.motion = bodies::Motion::kPrescribed;
  hand.prescribed = {.velocity_m_s = {0.0, 0.0, speed_m_s}};
  scene::SceneDescription scene =
      joined_scene({hand, link({0, 0, -0.03}, {0.02, 0.02, 0.04}, 0.05),
                    link({0, 0, -0.07}, {0.02, 0.02, 0.04}, 0.05)},
                   {joint(0, 1, {{0.0, 0.0, -0.01}}, 2000.0, 5.0),
                    joint(1, 2, {{0.0, 0.0, -0.05}}, 2000.0, 5.0)},
                   kGravity_m_s2, sim_server::material_of(1000.0, 1.0, 0.5));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  scene.sleeping = true;
  Simulation simulation(scene);
  for (int i = 0; i < 1000; ++i) {
    (void)advance(simulation, 0.01, 1);
    const int sleeping = count_sleeping(simulation);
    REQUIRE((sleeping == 0 || (sleeping == 2 && speed_m_s == 0.0)));
  }
  REQUIRE(count_sleeping(simulation) == (speed_m_s == 0.0 ? 2 : 0));
  if (speed_m_s > 0.0) return;

  // The tool wakes the lower one, and so both.
  (void)simulation.step(0.01, [] {
    return ToolSample{.time_ns = 1, .position_m = {0.0, 0.006, -0.0865}};
  });
  CHECK(count_sleeping(simulation) == 0);
}

TEST_CASE("Both integrators lead a joined chain the same way", "[joints]") {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    std::vector<Eigen::Vector3d> reference_m;
    for (const scene::IntegratorKind& kind : kBothIntegrators) {
      scene::SceneDescription scene = drawn_chain(seed, 1.0, kGravity_m_s2, true);
      scene.method.integrator = kind;
      Simulation simulation(scene);
      REQUIRE(advance(simulation, 2e-4, 500));
      std::vector<Eigen::Vector3d> places_m;
      for (const bodies::RigidBody& body : simulation.world().rigid_bodies)
        places_m.push_back(body.position_m);
      for (const bodies::Node& node : simulation.world().nodes) places_m.push_back(node.position_m);
      if (reference_m.empty()) reference_m = places_m;
      double off_m = 0.0;
      for (std::size_t i = 0; i < places_m.size(); ++i)
        off_m = std::max(off_m, (places_m[i] - reference_m[i]).norm());
      INFO(kind.name << ", seed " << seed);
      CHECK(off_m < 1e-3);  // of 50 mm that they fall
    }
  }
}

TEST_CASE("Joints count as stiffness, cost and memory", "[joints]") {
  const scene::SceneDescription scene = joined_scene({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                                                     {joint(0, -1, {{0, 0, 0}}, 1000.0, 2.0)});
  const SceneLoad load = load_of(scene::build_world(scene));
  CHECK(load.joints == 1.0);
  CHECK(load.spring_rad_s == Approx(std::sqrt(1000.0 / 0.1)));  // at its centre
  CHECK(load.damping_1_s == Approx(2.0 / 0.1));

  scene::SceneDescription without = scene;
  without.joints.clear();
  const Memory need = memory_need(scene.bodies[0], scene.method);
  CHECK_NOTHROW(require_room(without, "scene.toml", need));
  CHECK_THROWS(require_room(scene, "scene.toml", need));
}

}  // namespace
}  // namespace stillgrid::dynamics::joined_bodies_test
