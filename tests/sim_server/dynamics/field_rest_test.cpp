// How bodies that are met through fields rest, hold and yield.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "tests/sim_server/dynamics/field_bodies.hpp"

namespace stillgrid::dynamics::field_rest_test {
namespace {

using Eigen::Vector3d;

TEST_CASE("A ball that rests on a field stands as deep as its weight asks", "[field]") {
  const Way way = every_way();
  const double mass_kg = 0.083, radius_m = 0.0087, stiffness_N_per_m = 1130.0;
  const double top_m = 0.5 * kSize_m.z();
  const scene::SceneDescription scene = scene_by(
      way, {sim_server::sphere({0.003, 0.001, top_m + radius_m + 0.0013}, radius_m, mass_kg)},
      sim_server::material_of(stiffness_N_per_m, 3.0, 0.4));
  bodies::World world = scene::build_world(scene);
  sim_server::add_static_field(world, sim_server::box_field(kSize_m, 0.0015, 0.012),
                               Vector3d::Zero());
  Simulation simulation(scene, world);

  REQUIRE(advance(simulation, way.step_s, static_cast<int>(4.0 / way.step_s)));

  const double depth_m = top_m + radius_m - body(simulation).position_m.z();
  CHECK(depth_m == Approx(mass_kg * kGravity_m_s2 / stiffness_N_per_m).epsilon(2e-4));
  CHECK(fastest_m_s(simulation) < 1e-6);
}

TEST_CASE("A ball in a cradle of fields rests where it does in one of the balls themselves",
          "[field]") {
  const Way way = every_way();
  const double mass_kg = 0.083, radius_m = 0.0087, cradle_m = 0.0213;
  const auto rest_m = [&](bool by_fields) -> Vector3d {
    std::vector<bodies::BodyDescription> bodies{
        sim_server::sphere({0.0011, -0.0007, 0.028}, radius_m, mass_kg)};
    std::vector<Vector3d> at_m;
    for (const double turn_rad : {0.3, 2.5, 4.4})
      at_m.emplace_back(0.0224 * std::cos(turn_rad), 0.0224 * std::sin(turn_rad), 0.0013);
    if (!by_fields)
      for (const Vector3d& own_m : at_m) {
        bodies.push_back(sim_server::sphere(own_m, cradle_m, 0.0));
        bodies.back().motion = bodies::Motion::kStatic;
      }
    const scene::SceneDescription scene =
        scene_by(way, bodies, sim_server::material_of(1130.0, 3.0, 0.0));
    bodies::World world = scene::build_world(scene);
    if (by_fields)
      for (const Vector3d& own_m : at_m)
        sim_server::add_static_field(world, sim_server::ball_field(cradle_m, 0.001, 0.012), own_m,
                                     Eigen::Quaterniond(0.3, -0.5, 0.7, 0.1).normalized());
    Simulation simulation(scene, world);
    REQUIRE(advance(simulation, way.step_s, static_cast<int>(6.0 / way.step_s)));
    REQUIRE(fastest_m_s(simulation) < 1e-4);
    return body(simulation).position_m;
  };
  CHECK((rest_m(true) - rest_m(false)).norm() < 2e-5);
}

TEST_CASE("A body of points rests on a plane as deep as they share its weight, and stays",
          "[field]") {
  const Way way = every_way();
  const double mass_kg = 0.137, stiffness_N_per_m = 2100.0;
  const scene::SceneDescription scene =
      scene_by(way,
               {sim_server::points_body(sim_server::box_points(kSize_m, 4, 0.0011), kSize_m,
                                        mass_kg, {0.003, -0.002, 0.5 * kSize_m.z() + 0.0007}),
                sim_server::floor_at(0.0)},
               sim_server::material_of(stiffness_N_per_m, 1.0, 0.5));
  bodies::World world = scene::build_world(scene);
  sim_server::meet_by_field(world, 0, sim_server::box_field(kSize_m, 0.0015, 0.012));
  Simulation simulation(scene, world);
  REQUIRE(advance(simulation, way.step_s, static_cast<int>(3.0 / way.step_s)));
  const Vector3d rested_m = body(simulation).position_m;
  const double depth_m = 0.5 * kSize_m.z() - rested_m.z();
  CHECK(depth_m == Approx(mass_kg * kGravity_m_s2 / (16.0 * stiffness_N_per_m)).epsilon(1e-4));

  REQUIRE(advance(simulation, way.step_s, static_cast<int>(3.0 / way.step_s)));

  CHECK((body(simulation).position_m - rested_m).norm() < 1e-8);
}

TEST_CASE("A box on a box of fields rests, without creep, and sleeps by implicit Euler",
          "[field]") {
  const Way way = every_way();
  const double mass_kg = 0.137, stiffness_N_per_m = 2100.0;
  const auto box_at = [&](const Vector3d& at_m) {
    return sim_server::points_body(sim_server::box_points(kSize_m, 4, 0.0011), kSize_m, mass_kg,
                                   at_m);
  };
  scene::SceneDescription scene =
      scene_by(way,
               {box_at({0, 0, 0.5 * kSize_m.z()}), box_at({0.0043, -0.0029, 1.5 * kSize_m.z()}),
                sim_server::floor_at(0.0)},
               sim_server::material_of(stiffness_N_per_m, 1.0, 0.6));
  scene.sleeping = true;
  bodies::World world = scene::build_world(scene);
  for (const int i : {0, 1})
    sim_server::meet_by_field(world, i, sim_server::box_field(kSize_m, 0.0015, 0.012));
  Simulation simulation(scene, world);
  REQUIRE(advance(simulation, way.step_s, static_cast<int>(2.0 / way.step_s)));
  const Vector3d rested_m = body(simulation, 1).position_m;
  REQUIRE(rested_m.z() > 1.4 * kSize_m.z());
  REQUIRE((rested_m - Vector3d(0.0043, -0.0029, rested_m.z())).norm() < 1e-4);

  REQUIRE(advance(simulation, way.step_s, static_cast<int>(6.0 / way.step_s)));

  CHECK((body(simulation, 1).position_m - rested_m).norm() < 1e-6);
  const bool sleeps = simulation.world().bodies[1].is_sleeping;
  // The engine has no sleep in scenes with fields yet.
  CHECK(sleeps == !scene::is_by_engine(way.integrator));
}

TEST_CASE("Friction holds a body of a field on a slope that is a field, and lets it go beyond",
          "[field]") {
  const Way way = every_way();
  const bool holds = GENERATE(true, false);
  if (holds && scene::chooses_steps(way.integrator)) return;     // its friction is viscous
  const double tilt_rad = holds ? 0.27 : 0.36, friction = 0.32;  // tan: 0.277, 0.376
  scene::SceneDescription scene =
      scene_by(way,
               {sim_server::points_body(sim_server::box_points(kSize_m, 4, 0.0011), kSize_m, 0.137,
                                        {-0.05, 0.0, 0.5 * kSize_m.z() - 0.0001})},
               sim_server::material_of(2100.0, 2.0, friction));
  scene.gravity_m_s2 = kGravity_m_s2 * Vector3d(std::sin(tilt_rad), 0.0, -std::cos(tilt_rad));
  bodies::World world = scene::build_world(scene);
  sim_server::meet_by_field(world, 0, sim_server::box_field(kSize_m, 0.0015, 0.012));
  const Vector3d slope_m(0.41, 0.22, 0.037);
  sim_server::add_static_field(world, sim_server::box_field(slope_m, 0.003, 0.012),
                               {0.0, 0.0, -0.5 * slope_m.z()});
  Simulation simulation(scene, world);
  REQUIRE(advance(simulation, way.step_s, static_cast<int>(0.15 / way.step_s)));
  const Vector3d begun_m = body(simulation).position_m;
  const double begun_m_s = body(simulation).velocity_m_s.x();
  const int steps = static_cast<int>((holds ? 3.0 : 0.2) / way.step_s);

  REQUIRE(advance(simulation, way.step_s, steps));

  if (holds) {
    CHECK((body(simulation).position_m - begun_m).norm() < 3e-5);
    CHECK(fastest_m_s(simulation) < 1e-5);
  } else {
    const double expected_m_s2 =
        kGravity_m_s2 * (std::sin(tilt_rad) - friction * std::cos(tilt_rad));
    CHECK((body(simulation).velocity_m_s.x() - begun_m_s) / (steps * way.step_s) ==
          Approx(expected_m_s2).epsilon(0.03));
  }
}

std::optional<ToolSample> pressing_tool(const Simulation& simulation, double step_s,
                                        const Vector3d& at_m) {
  ToolSample sample;
  sample.time_ns = static_cast<std::uint64_t>((simulation.world().time_s + step_s) * 1e9);
  sample.position_m = at_m;
  return sample;
}

TEST_CASE("A tool that presses a body of a field presses it down by the springs in line",
          "[field]") {
  // The tool on the field, the field's points on the floor.
  const Way way = every_way();
  const double stiffness_N_per_m = 700.0, mass_kg = 0.137, tool_m = 0.0051;
  const Vector3d grip_m(0.003, -0.002, 0.5 * kSize_m.z() + tool_m - 0.0013);
  scene::SceneDescription scene =
      scene_by(way,
               {sim_server::points_body(sim_server::box_points(kSize_m, 4, 0.0011), kSize_m,
                                        mass_kg, {0.0, 0.0, 0.5 * kSize_m.z()}),
                sim_server::floor_at(0.0)},
               sim_server::material_of(stiffness_N_per_m, 2.0, 0.5));
  scene.tool = {{Vector3d::Zero(), tool_m}};
  bodies::World world = scene::build_world(scene);
  sim_server::meet_by_field(world, 0, sim_server::box_field(kSize_m, 0.0015, 0.012));
  Simulation simulation(scene, world);
  for (int i = 0; i < static_cast<int>(3.0 / way.step_s); ++i)
    (void)simulation.step(way.step_s, [&] {
      return pressing_tool(simulation, way.step_s, grip_m + Vector3d(0.0, 0.0, 0.5 * kSize_m.z()));
    });

  const auto depth_of = [&] {  // along the body's own axis
    const bodies::RigidBody& own = body(simulation);
    const Vector3d at_m = own.orientation.conjugate() *
                          (grip_m + Vector3d(0.0, 0.0, 0.5 * kSize_m.z()) - own.position_m);
    return 0.5 * kSize_m.z() + tool_m - at_m.z();
  };
  const double sunk_m = 0.5 * kSize_m.z() - body(simulation).position_m.z();
  const double force_N = stiffness_N_per_m * depth_of();
  REQUIRE(force_N > 0.1);
  CHECK(16.0 * stiffness_N_per_m * sunk_m ==
        Approx(force_N + mass_kg * kGravity_m_s2).epsilon(3e-3));
  CHECK(fastest_m_s(simulation) < 1e-6);
}

}  // namespace
}  // namespace stillgrid::dynamics::field_rest_test
