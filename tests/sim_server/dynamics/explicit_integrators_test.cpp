#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::explicit_integrators_test {
namespace {

scene::Method explicit_method(scene::IntegratorKind kind, int substeps = 0) {
  scene::Method method;
  method.integrator = kind;
  method.substeps = substeps;
  return method;
}

struct Balance {
  double gained_J = 0.0, given_J = 0.0, lost_J = 0.0;
  [[nodiscard]] double error_J() const { return gained_J - given_J + lost_J; }
};

/// How the energy of a scene changed over a time, and where it should have gone.
Balance balance_of(scene::SceneDescription scene, double step_s, int steps,
                   const scene::Method& method) {
  scene.method = method;
  Simulation simulation(scene);
  simulation.account_energy();
  REQUIRE(advance(simulation, step_s, steps));
  const EnergyAccount account = *simulation.energy_account();
  return {account.end.total_J() - account.start.total_J(), account.flow.given_J,
          account.flow.spring_damping_J + account.flow.contact_damping_J + account.flow.friction_J};
}

/// A cloth on a post, a box that slides on the floor, a ball that a prescribed one carries along.
scene::SceneDescription bustle() {
  bodies::BodyDescription cloth = sim_server::sheet({6, 6}, 0.02, 0.002, 300.0);
  sim_server::shear_stiffness_N_per_m(cloth) = 150.0;
  sim_server::springs(cloth).spring_damping_N_s_per_m = 0.05;
  sim_server::packing(cloth) = {0.02, 0.009};
  cloth.position_m = {0.0, 0.0, 0.045};
  bodies::BodyDescription post = sim_server::sphere({0.0, 0.0, 0.0}, 0.04, 0.0);
  post.motion = bodies::Motion::kStatic;
  bodies::BodyDescription block =
      sim_server::moving(sim_server::box({0.4, 0.0, 0.0199}, {0.04, 0.04, 0.04}, 0.1, {0.02, 0.01}),
                         {0.5, 0.2, 0.0}, {0.0, 0.0, 3.0});
  bodies::BodyDescription pusher = sim_server::sphere({-0.4, 0.0, 0.05}, 0.03, 0.0);
  pusher.motion = bodies::Motion::kPrescribed;
  pusher.prescribed.velocity_m_s = {0.3, 0.0, 0.0};
  bodies::BodyDescription ball = sim_server::sphere({-0.345, 0.01, 0.04}, 0.03, 0.05);
  scene::SceneDescription scene =
      sim_server::scene_of({cloth, post, block, pusher, ball, sim_server::floor_at(0.0)},
                           sim_server::material_of(2000.0, 2.0, 0.3, 0.01), {0.0, 0.0, -9.81});
  scene.sleeping = false;
  return scene;
}

struct Tumble {
  double momentum_error, energy_error;  // relative, the worst on the way
};

/// Three seconds of a free asymmetric body, in steps of 10 ms.
Tumble tumble(scene::IntegratorKind kind, int substeps) {
  const bodies::BodyDescription body =
      sim_server::moving(sim_server::box({0, 0, 0}, {0.03, 0.05, 0.11}, 0.2, {0.02, 0.01}),
                         {1, 0, 0}, {3.0, 14.0, 2.0});
  scene::SceneDescription scene = sim_server::scene_of({body});
  scene.method = explicit_method(kind, substeps);
  Simulation simulation(scene);
  const auto momentum = [&] {
    const bodies::RigidBody& rigid = std::as_const(simulation).world().rigid_bodies[0];
    return Eigen::Vector3d(rigid.orientation *
                           rigid.inertia_kg_m2.cwiseProduct(rigid.orientation.conjugate() *
                                                            rigid.angular_velocity_rad_s));
  };
  const Eigen::Vector3d before = momentum();
  const auto energy = [&] {
    return bodies::mechanical_energy_J(std::as_const(simulation).world());
  };
  const double energy_J = energy();
  Tumble worst{};
  for (int i = 0; i < 300; ++i) {
    REQUIRE(advance(simulation, 0.01, 1));
    worst.momentum_error =
        std::max(worst.momentum_error, (momentum() - before).norm() / before.norm());
    worst.energy_error = std::max(worst.energy_error, std::abs(energy() / energy_J - 1.0));
  }
  return worst;
}

TEST_CASE("Over two seconds energy goes where the flow says", "[explicit_integrators]") {
  const scene::IntegratorKind kind = scene::IntegratorKind::kVelocityVerlet;
  const int substeps = GENERATE(80, 320);
  const Balance balance = balance_of(bustle(), 0.005, 400, explicit_method(kind, substeps));
  CAPTURE(substeps, balance.error_J(), balance.gained_J);
  REQUIRE(balance.lost_J > 1.0);
  REQUIRE(balance.given_J > 0.5);
  CHECK(std::abs(balance.error_J()) < 1e-4 * (balance.lost_J + balance.given_J));
}

TEST_CASE("What a bounce loses is what its damper took", "[explicit_integrators]") {
  const scene::SceneDescription ball = sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, 0.0501}, 0.05, 0.1), {0, 0, -1.0}),
       sim_server::floor_at(0.0)},
      sim_server::material_of(1000.0, 4.0));
  const Balance balance =
      balance_of(ball, 0.001, 60, explicit_method(scene::IntegratorKind::kVelocityVerlet, 100));
  CHECK(balance.lost_J > 0.2 * 0.05);  // of 0.1 kg at 1 m/s
  CHECK(balance.given_J == 0.0);
  CHECK(std::abs(balance.error_J()) < 2e-3 * balance.lost_J);
}

TEST_CASE("A free asymmetric body keeps its angular momentum and its energy to rounding",
          "[explicit_integrators]") {
  const Tumble tumbled = tumble(scene::IntegratorKind::kVelocityVerlet, GENERATE(1, 20));
  CHECK(tumbled.momentum_error < 1e-10);
  CHECK(tumbled.energy_error < 1e-10);
}

TEST_CASE("As many substeps as asked, and as stability asks", "[explicit_integrators]") {
  // w_max = 2 sqrt(k/m) cos(pi/(2 (2 N + 1))): 1 / h >= w_max / 2 (docs/cases.md, 3.3).
  scene::SceneDescription chain =
      sim_server::scene_of({sim_server::thread(11, {0, 0, 0}, {1, 0, 0}, 0.01, 1000.0, {0})});
  const auto substeps_by = [&](int given) {
    chain.method = explicit_method(scene::IntegratorKind::kVelocityVerlet, given);
    Simulation simulation(chain);
    return simulation.step(0.1, [] { return std::nullopt; }).substeps;
  };
  CHECK(substeps_by(3) == 3);
  const int chosen = substeps_by(0);
  const double least = 0.1 * 625.3915 / 2.0;  // half as long as is stable
  CHECK(chosen >= 2.0 * least);
  CHECK(chosen <= 100.0);  // one a tick is enough
}

TEST_CASE("A step that does not stay finite says so, and leaves the world",
          "[explicit_integrators]") {
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::thread(5, {0, 0, 0}, {1, 0, 0}, 0.01, 1000.0, {0}),
                            sim_server::box({2, 0, 0}, {0.1, 0.1, 0.1}, 1.0, {0.05, 0.02})});
  scene.method = explicit_method(scene::IntegratorKind::kVelocityVerlet, 4);
  Simulation simulation(scene);
  REQUIRE(advance(simulation, 1e-3, 1));
  simulation.world().nodes[4].velocity_m_s.x() = std::numeric_limits<double>::max();
  const double before_m = simulation.world().nodes[3].position_m.x();
  CHECK_THROWS_WITH(advance(simulation, 1.0, 1), Catch::Contains("is not finite"));
  CHECK(simulation.world().nodes[3].position_m.x() == before_m);
}

TEST_CASE("Two runs agree to the bit", "[explicit_integrators]") {
  scene::SceneDescription scene = bustle();
  scene.method = explicit_method(scene::IntegratorKind::kVelocityVerlet);
  Simulation one(scene), two(scene);
  for (Simulation* simulation : {&one, &two}) REQUIRE(advance(*simulation, 0.005, 20));
  for (std::size_t i = 0; i < one.world().nodes.size(); ++i)
    CHECK(one.world().nodes[i].position_m == two.world().nodes[i].position_m);
  for (std::size_t i = 0; i < one.world().rigid_bodies.size(); ++i)
    CHECK(one.world().rigid_bodies[i].position_m == two.world().rigid_bodies[i].position_m);
}

}  // namespace
}  // namespace stillgrid::dynamics::explicit_integrators_test
