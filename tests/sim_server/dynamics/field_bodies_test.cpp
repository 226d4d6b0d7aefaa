#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/field_worlds.hpp"

namespace stillgrid::dynamics {
namespace {

using Eigen::Vector3d;
using scene::IntegratorKind;

constexpr double kGravity_m_s2 = 9.79;
const Vector3d kSize_m(0.061, 0.047, 0.033);

/// Every integrator, a step of its own for each family.
struct Way {
  IntegratorKind integrator;
  double step_s;
};
Way every_way() {
  return GENERATE(Way{IntegratorKind::kVelocityVerlet, 0.0113},
                  Way{IntegratorKind::kSymplecticEuler, 0.0113},
                  Way{IntegratorKind::kImplicitEuler, 0.0113}, Way{IntegratorKind::kBdf2, 0.0077},
                  Way{IntegratorKind::kTrapezoid, 0.0031},
                  Way{IntegratorKind::kCvodeBdf, 0.0113});
}

scene::SceneDescription scene_by(const Way& way, std::vector<bodies::BodyDescription> bodies,
                                 const scene::MaterialDescription& material,
                                 double gravity_m_s2 = kGravity_m_s2) {
  scene::SceneDescription scene =
      sim_server::scene_of(std::move(bodies), material, {0, 0, -gravity_m_s2});
  scene.method.integrator = way.integrator;
  if (scene::chooses_steps(way.integrator)) scene.method.tolerance_m_s = 1e-6;
  return scene;
}

const bodies::RigidBody& body(const Simulation& simulation, std::size_t i = 0) {
  return simulation.world().rigid_bodies[i];
}
double fastest_m_s(const Simulation& simulation) {
  double most = 0.0;
  for (const bodies::RigidBody& own : simulation.world().rigid_bodies)
    if (own.free)
      most = std::max(most, own.velocity_m_s.norm() +
                                own.bounding_radius_m * own.angular_velocity_rad_s.norm());
  return most;
}

TEST_CASE("A ball that rests on a field stands as deep as its weight asks", "[field]") {
  const Way way = every_way();
  const double mass_kg = 0.083, radius_m = 0.0087, stiffness_N_per_m = 1130.0;
  const bool on_ball = GENERATE(false, true);
  const sim_server::Field field = on_ball ? sim_server::ball_field(0.031, 0.002, 0.012)
                                          : sim_server::box_field(kSize_m, 0.0015, 0.012);
  const double top_m = on_ball ? 0.031 : 0.5 * kSize_m.z();
  const scene::SceneDescription scene = scene_by(
      way, {sim_server::sphere({0.0, 0.0, top_m + radius_m + 0.0013}, radius_m, mass_kg)},
      sim_server::material_of(stiffness_N_per_m, 3.0, 0.4));
  bodies::World world = scene::build_world(scene);
  sim_server::add_static_field(world, field, Vector3d::Zero());
  Simulation simulation(scene, world);

  REQUIRE(advance(simulation, way.step_s, static_cast<int>(4.0 / way.step_s)));

  const double depth_m = top_m + radius_m - body(simulation).position_m.z();
  CHECK(depth_m == Approx(mass_kg * kGravity_m_s2 / stiffness_N_per_m).epsilon(on_ball ? 0.01 : 2e-4));
  CHECK(fastest_m_s(simulation) < 1e-6);
}

TEST_CASE("A body of points rests on a plane as deep as they share its weight, and stays",
          "[field]") {
  const Way way = every_way();
  const double mass_kg = 0.137, stiffness_N_per_m = 2100.0;
  const scene::SceneDescription scene = scene_by(
      way,
      {sim_server::points_body(sim_server::box_points(kSize_m, 4, 0.0011), kSize_m, mass_kg,
                               {0.003, -0.002, 0.5 * kSize_m.z() + 0.0007}),
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

TEST_CASE("A box on a box of fields rests, without creep, and sleeps", "[field]") {
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
  CHECK(sleeps);
}

}  // namespace
}  // namespace stillgrid::dynamics
