// What bodies that are met through fields give each other as they collide.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "tests/sim_server/dynamics/field_bodies.hpp"

namespace stillgrid::dynamics::field_collision_test {
namespace {

using Eigen::Vector3d;
using scene::IntegratorKind;

/// Two bodies of fields in free flight, one a ball, that meet off their centres.
struct Flight {
  scene::SceneDescription scene;
  bodies::World world;
};
Flight flight(const Way& way, unsigned seed, const scene::MaterialDescription& material) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] { return Vector3d(unit(random), unit(random), unit(random)); };
  const double radius_m = 0.0232;
  bodies::BodyDescription box = sim_server::points_body(sim_server::box_points(kSize_m, 5, 0.0009),
                                                        kSize_m, 0.137, 0.004 * vector());
  box.orientation = Eigen::Quaterniond(1.0, unit(random), unit(random), unit(random)).normalized();
  bodies::BodyDescription ball = sim_server::points_body(
      sim_server::ball_points(radius_m, 120, 0.0009), Vector3d::Constant(radius_m), 0.071,
      Vector3d(0.085, 0.0, 0.0) + 0.006 * vector());
  Flight flight{scene_by(way,
                         {sim_server::moving(box, 0.02 * vector(), 3.0 * vector()),
                          sim_server::moving(ball, Vector3d(-0.41, 0.0, 0.0) + 0.05 * vector(),
                                             5.0 * vector())},
                         material, 0.0),
                {}};
  flight.world = scene::build_world(flight.scene);
  sim_server::meet_by_field(flight.world, 0, sim_server::box_field(kSize_m, 0.0015, 0.012));
  sim_server::meet_by_field(flight.world, 1, sim_server::ball_field(radius_m, 0.0015, 0.012));
  return flight;
}

TEST_CASE("Two bodies of fields that collide keep their momenta", "[field]") {
  // Implicit steps take levers at their end.
  struct Case {
    Way way;
    double angular;  // relative
  };
  const Case own = GENERATE(Case{{IntegratorKind::kVelocityVerlet, 0.0053}, 1e-5},
                            Case{{IntegratorKind::kImplicitEuler, 0.0013}, 0.1});
  const auto seed = GENERATE(range(1U, 9U));
  const Flight flown = flight(own.way, seed, sim_server::material_of(870.0, 0.7, 0.35));
  Simulation simulation(flown.scene, flown.world);
  const Vector3d momentum_N_s = momentum_kg_m_per_s(simulation.world()),
                 angular_N_m_s = angular_momentum_kg_m2_per_s(simulation.world());

  int most_contacts = 0;
  for (double time_s = 0.0; time_s < 0.35; time_s += own.way.step_s)
    most_contacts = std::max(most_contacts, simulation.step(own.way.step_s, no_tool).contacts);

  REQUIRE(most_contacts > 0);
  CHECK((momentum_kg_m_per_s(simulation.world()) - momentum_N_s).norm() <
        1e-6 * momentum_N_s.norm());
  CHECK((angular_momentum_kg_m2_per_s(simulation.world()) - angular_N_m_s).norm() <
        own.angular * angular_N_m_s.norm());
}

TEST_CASE("A collision of fields makes no energy, and the account closes", "[field]") {
  // Explicit: what substeps err, which shrinks by their square.
  struct Case {
    Way way;
    double made;  // of the energy at the start
  };
  const Case own = GENERATE(Case{{IntegratorKind::kVelocityVerlet, 0.0053}, 0.006},
                            Case{{IntegratorKind::kVelocityVerlet, 0.0011}, 0.002},
                            Case{{IntegratorKind::kVelocityVerlet, 0.00023}, 0.0002},
                            Case{{IntegratorKind::kImplicitEuler, 0.0053}, 1e-9},
                            Case{{IntegratorKind::kImplicitEuler, 0.0011}, 1e-9});
  const auto seed = GENERATE(1U, 2U, 3U, 4U, 6U);
  const double friction = GENERATE(0.0, 0.35);
  const Flight flown = flight(own.way, seed, sim_server::material_of(870.0, 0.0, friction));
  Simulation simulation(flown.scene, flown.world);
  simulation.account_energy();
  int most_contacts = 0;
  for (double time_s = 0.0; time_s < 0.35; time_s += own.way.step_s)
    most_contacts = std::max(most_contacts, simulation.step(own.way.step_s, no_tool).contacts);
  REQUIRE(most_contacts > 0);

  const EnergyAccount account = *simulation.energy_account();
  const double start_J = account.start.total_J();
  CHECK(account.end.contacts_J == 0.0);
  CHECK(account.end.total_J() + account.flow.friction_J < (1.0 + own.made) * start_J);
  CHECK(account.end.total_J() > 0.3 * start_J);
  if (scene::is_explicit(own.way.integrator))
    CHECK(std::abs(account.numerical_J()) < own.made * start_J);
}

TEST_CASE("A ball on a field comes back as fast as the contact law says", "[field]") {
  // zeta = 0.2: restitution exp(-(z/q) acos z) = 0.756135 [known answers].
  const Way way = GENERATE(Way{IntegratorKind::kVelocityVerlet, 0.0007},
                           Way{IntegratorKind::kImplicitEuler, 0.00003},
                           Way{IntegratorKind::kCvodeBdf, 0.0007});
  const double mass_kg = 0.1, stiffness_N_per_m = 1000.0, radius_m = 0.0087;
  const bool moves = GENERATE(false, true);  // the field, at the ball's rest
  scene::SceneDescription scene = scene_by(
      way,
      {sim_server::moving(sim_server::sphere({0.0, 0.0, 0.028}, radius_m, mass_kg), {0, 0, -0.31}),
       sim_server::points_body(sim_server::ball_points(0.0232, 20, 0.001),
                               Vector3d::Constant(0.0232), mass_kg, {0, 0, -0.006})},
      sim_server::material_of(stiffness_N_per_m,
                              0.4 * std::sqrt(stiffness_N_per_m * mass_kg * (moves ? 0.5 : 1.0)),
                              0.0),
      0.0);
  if (!moves) scene.bodies.pop_back();
  if (scene::chooses_steps(way.integrator)) scene.method.tolerance_m_s = 1e-8;
  bodies::World world = scene::build_world(scene);
  const sim_server::Field field = sim_server::ball_field(0.0232, 0.001, 0.012);
  if (moves)
    sim_server::meet_by_field(world, 1, field);
  else
    sim_server::add_static_field(world, field, {0, 0, -0.006});
  Simulation simulation(scene, world);

  REQUIRE(advance(simulation, way.step_s, static_cast<int>(0.08 / way.step_s)));

  const double other_m_s = moves ? body(simulation, 1).velocity_m_s.z() : 0.0;
  CHECK((body(simulation).velocity_m_s.z() - other_m_s) / 0.31 == Approx(0.756135).epsilon(0.01));
}

TEST_CASE("A scene of fields that is turned and moved moves alike", "[field]") {
  const Way way = GENERATE(Way{IntegratorKind::kVelocityVerlet, 0.0053},
                           Way{IntegratorKind::kImplicitEuler, 0.0053});
  const auto seed = GENERATE(5U, 6U);
  const Flight own = flight(way, seed, sim_server::material_of(870.0, 0.7, 0.35));
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.4, 0.5, -0.3, 0.8).normalized();
  const Vector3d shift_m(0.13, -0.21, 0.05);
  bodies::World seen = own.world;
  for (bodies::RigidBody& body : seen.rigid_bodies) {
    body.position_m = turn * body.position_m + shift_m;
    body.velocity_m_s = turn * body.velocity_m_s;
    body.angular_velocity_rad_s = turn * body.angular_velocity_rad_s;
    body.orientation = turn * body.orientation;
  }
  Simulation here(own.scene, own.world), there(own.scene, seen);
  for (double time_s = 0.0; time_s < 0.3; time_s += way.step_s) {
    (void)here.step(way.step_s, no_tool);
    (void)there.step(way.step_s, no_tool);
  }
  for (const std::size_t i : {0U, 1U}) {
    CHECK((turn * body(here, i).position_m + shift_m - body(there, i).position_m).norm() < 1e-6);
    CHECK((turn * body(here, i).velocity_m_s - body(there, i).velocity_m_s).norm() < 1e-5);
  }
}

TEST_CASE("A fast ball does not pass through a plate that is a field", "[field]") {
  const Way way = GENERATE(Way{IntegratorKind::kVelocityVerlet, 0.0113},
                           Way{IntegratorKind::kImplicitEuler, 0.0113});
  const auto seed = GENERATE(1U, 2U, 3U, 4U, 5U, 6U);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double speed_m_s = 3.0 + 2.0 * unit(random);
  const bool plate_flies = GENERATE(false, true);
  const Vector3d plate_m(0.11, 0.09, 0.006);
  std::vector<bodies::BodyDescription> bodies{sim_server::moving(
      sim_server::sphere({0.01 * unit(random), 0.01 * unit(random), 0.03 + 0.005 * unit(random)},
                         0.0043, 0.005),
      {0.2 * unit(random), 0.2 * unit(random), plate_flies ? 0.0 : -speed_m_s})};
  if (plate_flies)
    bodies.push_back(
        sim_server::moving(sim_server::points_body(sim_server::box_points(plate_m, 3, 0.001),
                                                   plate_m, 0.9, Vector3d::Zero()),
                           {0.0, 0.0, speed_m_s}));
  const scene::SceneDescription scene =
      scene_by(way, bodies, sim_server::material_of(41000.0, 0.0, 0.0), 0.0);
  bodies::World world = scene::build_world(scene);
  const sim_server::Field field = sim_server::box_field(plate_m, 0.0012, 0.012);
  if (plate_flies)
    sim_server::meet_by_field(world, 1, field);
  else
    sim_server::add_static_field(world, field, Vector3d::Zero());
  Simulation simulation(scene, world);

  (void)advance(simulation, way.step_s, 9);

  const double plate_z_m = plate_flies ? body(simulation, 1).position_m.z() : 0.0;
  CHECK(body(simulation).position_m.z() > plate_z_m);
}

TEST_CASE("What a prescribed body of a field gives a ball is all that the ball has", "[field]") {
  const Way way = GENERATE(Way{IntegratorKind::kVelocityVerlet, 0.0017},
                           Way{IntegratorKind::kImplicitEuler, 0.00007});
  const double mass_kg = 0.023, radius_m = 0.0071, paddle_m_s = 0.31;
  bodies::BodyDescription paddle = sim_server::points_body(
      sim_server::box_points(kSize_m, 3, 0.001), kSize_m, 0.0, Vector3d::Zero());
  paddle.motion = bodies::Motion::kPrescribed;
  paddle.prescribed = {.velocity_m_s = paddle_m_s * Vector3d::UnitZ()};
  const scene::SceneDescription scene = scene_by(
      way,
      {sim_server::sphere({0.004, 0.003, 0.5 * kSize_m.z() + radius_m + 0.0019}, radius_m, mass_kg),
       paddle},
      sim_server::material_of(900.0, 0.0, 0.3), 0.0);
  bodies::World world = scene::build_world(scene);
  sim_server::meet_by_field(world, 1, sim_server::box_field(kSize_m, 0.0015, 0.012));
  Simulation simulation(scene, world);
  simulation.account_energy();

  REQUIRE(advance(simulation, way.step_s, static_cast<int>(0.06 / way.step_s)));

  const EnergyAccount account = *simulation.energy_account();
  const Vector3d velocity_m_s = body(simulation).velocity_m_s;
  REQUIRE(account.end.contacts_J == 0.0);
  CHECK(velocity_m_s.z() == Approx(2.0 * paddle_m_s).epsilon(0.02));
  CHECK(account.flow.given_J == Approx(0.5 * mass_kg * velocity_m_s.squaredNorm()).epsilon(0.02));
}

}  // namespace
}  // namespace stillgrid::dynamics::field_collision_test
