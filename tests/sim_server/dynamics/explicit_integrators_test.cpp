#include "sim_server/dynamics/integrators/explicit_integrators.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "sim_server/contact/detection.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::explicit_integrators_test {
namespace {

scene::Method explicit_method(scene::IntegratorKind kind, int substeps = 0) {
  scene::Method method;
  method.integrator = kind;
  method.substeps = substeps;
  return method;
}

/// Energy of the springs of contacts at the world's state.
double contact_energy_J(const bodies::World& world, const std::vector<contact::Contact>& contacts) {
  double energy_J = 0.0;
  for (const contact::Contact& contact : contacts) {
    const auto at = [&](int sphere) {
      return bodies::sphere_motion(world, world.spheres[static_cast<std::size_t>(sphere)])
          .position_m;
    };
    const Eigen::Vector3d a_m = at(contact.a);
    double depth_m = 0.0;
    if (contact.is_plane)
      depth_m = contact.radius_a_m - (contact.plane_normal.dot(a_m) - contact.plane_offset_m);
    else
      depth_m = contact.radius_a_m + contact.radius_b_m -
                (a_m - (contact.b >= 0 ? at(contact.b) : contact.position_b_m)).norm();
    if (depth_m > 0.0) energy_J += 0.5 * contact.material.stiffness_N_per_m * depth_m * depth_m;
  }
  return energy_J;
}

struct Balance {
  double gained_J = 0.0, given_J = 0.0, lost_J = 0.0;
  [[nodiscard]] double error_J() const { return gained_J - given_J + lost_J; }
};

/// How the energy of a scene changed over a time, and where it should have gone.
Balance balance_of(bodies::World world, double step_s, int steps, const scene::Method& method) {
  ExplicitIntegrator integrator(method);
  contact::Detection detection(world, 1.0);
  Balance balance;
  Budget budget;
  for (int i = 0; i < steps; ++i) {
    detection.find_contacts(world, step_s);
    // Listed anew each step: what is on no list does not touch.
    const double before_J =
        bodies::mechanical_energy_J(world) + contact_energy_J(world, detection.contacts());
    REQUIRE(integrator.advance(world, detection.contacts(), step_s, budget).converged);
    integrator.commit(world, step_s);
    const EnergyFlow flow = *integrator.flow();
    balance.gained_J += bodies::mechanical_energy_J(world) +
                        contact_energy_J(world, detection.contacts()) - before_J;
    balance.given_J += flow.given_J;
    balance.lost_J += flow.spring_damping_J + flow.contact_damping_J + flow.friction_J;
    detection.move_spheres(world);
  }
  return balance;
}

/// A cloth on a post, a box that slides on the floor, a ball that a prescribed one carries along.
bodies::World bustle() {
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
  return scene::build_world(
      sim_server::scene_of({cloth, post, block, pusher, ball, sim_server::floor_at(0.0)},
                           sim_server::material_of(2000.0, 2.0, 0.3, 0.01), {0.0, 0.0, -9.81}));
}

struct Tumble {
  double momentum_error, energy_error;  // relative, the worst on the way
};

/// Three seconds of a free asymmetric body, in steps of 10 ms.
Tumble tumble(scene::IntegratorKind kind, int substeps) {
  const bodies::BodyDescription body =
      sim_server::moving(sim_server::box({0, 0, 0}, {0.03, 0.05, 0.11}, 0.2, {0.02, 0.01}),
                         {1, 0, 0}, {3.0, 14.0, 2.0});
  bodies::World world = scene::build_world(sim_server::scene_of({body}));
  const auto momentum = [&] {
    const bodies::RigidBody& rigid = world.rigid_bodies[0];
    return Eigen::Vector3d(rigid.orientation *
                           rigid.inertia_kg_m2.cwiseProduct(rigid.orientation.conjugate() *
                                                            rigid.angular_velocity_rad_s));
  };
  const Eigen::Vector3d before = momentum();
  const double energy_J = bodies::mechanical_energy_J(world);
  ExplicitIntegrator integrator(explicit_method(kind, substeps));
  Budget budget;
  Tumble worst{};
  for (int i = 0; i < 300; ++i) {
    REQUIRE(integrator.advance(world, {}, 0.01, budget).converged);
    integrator.commit(world, 0.01);
    worst.momentum_error =
        std::max(worst.momentum_error, (momentum() - before).norm() / before.norm());
    worst.energy_error =
        std::max(worst.energy_error, std::abs(bodies::mechanical_energy_J(world) / energy_J - 1.0));
  }
  return worst;
}

TEST_CASE("Over two seconds energy goes where the flow says, to first order of the substep",
          "[explicit_integrators]") {
  const scene::IntegratorKind kind = scene::IntegratorKind::kVelocityVerlet;
  const Balance coarse = balance_of(bustle(), 0.005, 400, explicit_method(kind, 80)),
                fine = balance_of(bustle(), 0.005, 400, explicit_method(kind, 320));
  CAPTURE(scene::name_of(kind));
  CAPTURE(coarse.error_J(), fine.error_J(), fine.gained_J);
  REQUIRE(fine.lost_J > 1.0);
  REQUIRE(fine.given_J > 0.5);
  CHECK(std::abs(fine.error_J()) < 0.03 * (fine.lost_J + fine.given_J));
  CHECK(std::abs(fine.error_J()) < 0.3 * std::abs(coarse.error_J()));
  const double limit_J = (4.0 * fine.error_J() - coarse.error_J()) / 3.0;
  CHECK(std::abs(limit_J) < 0.005 * (fine.lost_J + fine.given_J));
}

TEST_CASE("What a bounce loses is what its damper took", "[explicit_integrators]") {
  const bodies::World ball = scene::build_world(sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, 0.0501}, 0.05, 0.1), {0, 0, -1.0}),
       sim_server::floor_at(0.0)},
      sim_server::material_of(1000.0, 4.0)));
  const Balance balance =
      balance_of(ball, 0.001, 60, explicit_method(scene::IntegratorKind::kVelocityVerlet, 100));
  CHECK(balance.lost_J > 0.2 * 0.05);  // of 0.1 kg at 1 m/s
  CHECK(balance.given_J == 0.0);
  CHECK(std::abs(balance.error_J()) < 2e-3 * balance.lost_J);
}

TEST_CASE(
    "A free asymmetric body keeps its angular momentum to rounding, its energy as steps shrink",
    "[explicit_integrators]") {
  const scene::IntegratorKind kind = scene::IntegratorKind::kVelocityVerlet;
  const Tumble coarse = tumble(kind, 20), fine = tumble(kind, 40);
  CHECK(fine.momentum_error < 1e-12);
  CHECK(fine.energy_error < 0.004);
  CHECK(fine.energy_error < 0.5 * coarse.energy_error);  // of first order, and more at first
}

TEST_CASE("As many substeps as asked, and as stability asks", "[explicit_integrators]") {
  // w_max = 2 sqrt(k/m) cos(pi/(2 (2 N + 1))): 1 / h >= w_max / 2 (docs/cases.md, 3.3).
  const bodies::World chain = scene::build_world(
      sim_server::scene_of({sim_server::thread(11, {0, 0, 0}, {1, 0, 0}, 0.01, 1000.0, {0})}));
  Budget budget;
  const scene::IntegratorKind kind = scene::IntegratorKind::kVelocityVerlet;
  ExplicitIntegrator given(explicit_method(kind, 3)), chosen(explicit_method(kind));
  (void)given.advance(chain, {}, 0.1, budget);
  CHECK(given.substeps() == 3);
  (void)chosen.advance(chain, {}, 0.1, budget);
  const double least = 0.1 * 625.3915 / 2.0;  // half as long as is stable
  CHECK(chosen.substeps() >= 2.0 * least);
  CHECK(chosen.substeps() < 2.1 * least + 1.0);
}

TEST_CASE("A step that does not stay finite says so", "[explicit_integrators]") {
  bodies::World world = scene::build_world(
      sim_server::scene_of({sim_server::thread(5, {0, 0, 0}, {1, 0, 0}, 0.01, 1000.0, {0}),
                            sim_server::box({2, 0, 0}, {0.1, 0.1, 0.1}, 1.0, {0.05, 0.02})}));
  ExplicitIntegrator integrator(explicit_method(scene::IntegratorKind::kVelocityVerlet, 4));
  Budget budget;
  (void)integrator.advance(world, {}, 1e-3, budget);
  CHECK(integrator.trial().is_finite);
  world.nodes[4].velocity_m_s.x() = std::numeric_limits<double>::max();
  CHECK_FALSE(integrator.advance(world, {}, 1.0, budget).converged);
  CHECK_FALSE(integrator.trial().is_finite);
}

TEST_CASE("Two runs agree to the bit", "[explicit_integrators]") {
  const scene::IntegratorKind kind = scene::IntegratorKind::kVelocityVerlet;
  bodies::World one = bustle(), two = one;
  for (bodies::World* world : {&one, &two}) {
    ExplicitIntegrator integrator(explicit_method(kind));
    contact::Detection detection(*world, 1.0);
    Budget budget;
    for (int i = 0; i < 20; ++i) {
      detection.find_contacts(*world, 0.005);
      (void)integrator.advance(*world, detection.contacts(), 0.005, budget);
      integrator.commit(*world, 0.005);
    }
  }
  for (std::size_t i = 0; i < one.nodes.size(); ++i)
    CHECK(one.nodes[i].position_m == two.nodes[i].position_m);
  for (std::size_t i = 0; i < one.rigid_bodies.size(); ++i)
    CHECK(one.rigid_bodies[i].position_m == two.rigid_bodies[i].position_m);
}

TEST_CASE("A contact that is only listed changes no bit of what nothing touches",
          "[explicit_integrators]") {
  const scene::IntegratorKind kind = scene::IntegratorKind::kVelocityVerlet;
  bodies::World alone = bustle(), listed = alone;
  contact::Contact far;
  far.radius_a_m = 0.01;
  far.is_plane = true;
  far.plane_normal = {0.0, 0.0, 1.0};
  far.plane_offset_m = -1000.0;
  ExplicitIntegrator integrator(explicit_method(kind)), other(explicit_method(kind));
  Budget budget;
  for (const double step_s : {0.004, 0.004, 0.01, 0.001}) {
    CHECK(integrator.advance(alone, {}, step_s, budget).converged);
    CHECK(other.advance(listed, {&far, 1}, step_s, budget).converged);
    CHECK(integrator.substeps() == other.substeps());
    CHECK(integrator.flow()->spring_damping_J == other.flow()->spring_damping_J);
    integrator.commit(alone, step_s);
    other.commit(listed, step_s);
  }
  for (std::size_t i = 0; i < alone.nodes.size(); ++i) {
    CHECK(alone.nodes[i].position_m == listed.nodes[i].position_m);
    CHECK(alone.nodes[i].velocity_m_s == listed.nodes[i].velocity_m_s);
  }
  for (std::size_t i = 0; i < alone.rigid_bodies.size(); ++i) {
    CHECK(alone.rigid_bodies[i].position_m == listed.rigid_bodies[i].position_m);
    CHECK(alone.rigid_bodies[i].velocity_m_s == listed.rigid_bodies[i].velocity_m_s);
  }
}

TEST_CASE("Contacts that a part cannot solve have it begin anew in halves, as if asked for them",
          "[explicit_integrators]") {
  // Light and heavy balls in a row, pressed into each other far harder than the part is short.
  std::vector<bodies::BodyDescription> row;
  for (int i = 0; i < 16; ++i)
    row.push_back(sim_server::moving(
        sim_server::sphere({0.0199 * i, 1e-4 * (i % 3), 0}, 0.01, i % 2 == 0 ? 1e-3 : 0.1),
        {0, 0.3 * (i % 2), 0}));
  const bodies::World world = scene::build_world(
      sim_server::scene_of(row, sim_server::material_of(4e6, 10.0, 0.5), {0, 0, -9.81}));
  const double step_s = 0.004;
  contact::Detection detection(world, 1.0);
  detection.find_contacts(world, step_s);
  Budget budget;
  const scene::IntegratorKind kind = scene::IntegratorKind::kVelocityVerlet;
  ExplicitIntegrator halved(explicit_method(kind));
  // As it would begin: no spring asks for substeps, only how fast what touches nears.
  ExplicitIntegrator once(explicit_method(kind, 1));
  REQUIRE_FALSE(once.advance(world, detection.contacts(), step_s, budget).converged);

  CHECK(halved.advance(world, detection.contacts(), step_s, budget).converged);

  REQUIRE(halved.substeps() > 1);
  ExplicitIntegrator asked(explicit_method(kind, halved.substeps()));
  CHECK(asked.advance(world, detection.contacts(), step_s, budget).converged);
  for (std::size_t i = 0; i < world.rigid_bodies.size(); ++i) {
    CHECK(halved.trial().rigid_bodies[i].position_m == asked.trial().rigid_bodies[i].position_m);
    CHECK(halved.trial().rigid_bodies[i].velocity_m_s ==
          asked.trial().rigid_bodies[i].velocity_m_s);
  }
  CHECK(halved.flow()->friction_J == asked.flow()->friction_J);
}

}  // namespace
}  // namespace stillgrid::dynamics::explicit_integrators_test
