#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "shared/realtime/processor_time.hpp"
#include "sim_server/contact/detection.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/integrators/integrator.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::bounded_step_test {
namespace {

const Eigen::Vector3d kGravity_m_s2(0.0, 0.0, -9.81);

/// A block that lands, sliding and turning a little, on a floor against which k h^2 / m is 3e4.
bodies::World landing() {
  bodies::BodyDescription block =
      sim_server::box({0, 0, 0.021}, {0.03, 0.03, 0.04}, 0.02, {0.01, 0.005});
  return scene::build_world(sim_server::scene_of(
      {sim_server::moving(block, {0.4, 0, -1.0}, {0.5, 0, 0}), sim_server::floor_at(0.0)},
      sim_server::material_of(5e5, 2.5, 0.5), kGravity_m_s2));
}

/// Two springs pressed to 0.8 of their length, and the mass between them beside their line.
bodies::World pressed_springs() {
  bodies::World world = scene::build_world(sim_server::scene_of(
      {sim_server::thread(3, {-0.02, 0, 0}, {0.02, 0, 0}, 0.01, 1000.0, {0, 2})}));
  world.nodes[0].position_m.x() = -0.016;
  world.nodes[2].position_m.x() = 0.016;
  world.nodes[1].position_m.y() = 1e-5;
  return world;
}

/// Four stiff blocks on top of each other, falling the last tenth of a millimetre.
bodies::World stack() {
  std::vector<bodies::BodyDescription> bodies{sim_server::floor_at(0.0)};
  for (int i = 0; i < 4; ++i)
    bodies.push_back(sim_server::box({2e-4 * i, 0, 0.0151 + 0.0301 * i}, {0.03, 0.03, 0.03}, 0.1,
                                     {0.02, 0.005}));
  return scene::build_world(
      sim_server::scene_of(bodies, sim_server::material_of(1e5, 1.0, 0.5), kGravity_m_s2));
}

/// A crumpled sheet of stiff springs.
bodies::World crumpled_sheet() {
  bodies::BodyDescription body = sim_server::sheet({6, 6}, 0.02, 0.002, 5000.0);
  sim_server::shear_stiffness_N_per_m(body) = 2500.0;
  bodies::World world = scene::build_world(sim_server::scene_of({body}, {}, kGravity_m_s2));
  for (std::size_t i = 0; i < world.nodes.size(); ++i)
    world.nodes[i].position_m *= 0.7 + 0.05 * std::sin(3.0 * static_cast<double>(i));
  return world;
}

/// Of all kinds, contact springs included.
double energy_J(const bodies::World& world, std::span<const contact::Contact> contacts) {
  MechanicalSystem system(world, contacts);
  system.place(Eigen::VectorXd::Zero(system.size()), system.velocity(), 0.0, 0.0);
  return system.energy_J();
}

TEST_CASE(
    "The time of a budget is what its thread computes, whoever asks and however long it waits",
    "[budget]") {
  Budget budget;
  budget.end_within(20'000'000);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  CHECK_FALSE(budget.is_late());
  bool is_late_elsewhere = true;
  const auto ask = [&] { is_late_elsewhere = budget.is_late(); };
  std::thread(ask).join();
  CHECK_FALSE(is_late_elsewhere);

  const double began_s = realtime::thread_processor_s();
  while (realtime::thread_processor_s() - began_s < 0.03) {
  }
  CHECK(budget.is_late());
  std::thread(ask).join();
  CHECK(is_late_elsewhere);
}

TEST_CASE("Whatever its budget, a step of implicit Euler cut short gains no energy",
          "[bounded_step]") {
  bodies::World world = GENERATE(landing(), pressed_springs(), stack(), crumpled_sheet());
  const int iterations = GENERATE(0, 1, 2, 3, 5);
  constexpr double kStep_s = 0.033;
  const auto integrator = make_integrator({});
  contact::Detection detection(world, 1.0);
  int cut_short = 0;
  for (int i = 0; i < 20; ++i) {
    detection.find_contacts(world, kStep_s);
    const double before_J = energy_J(world, detection.contacts());
    Budget budget{.iterations = iterations};

    const SolveReport report = integrator->advance(world, detection.contacts(), kStep_s, budget);
    integrator->commit(world, kStep_s);

    CHECK(report.iterations <= iterations);
    if (report.converged) continue;
    ++cut_short;
    CHECK(energy_J(world, detection.contacts()) <= before_J + 1e-12 * std::abs(before_J));
  }
  CHECK((cut_short > 0 || iterations >= 3));
}

TEST_CASE("A step that does not stay finite says so", "[bounded_step]") {
  bodies::World world = landing();
  world.gravity_m_s2.x() = std::numeric_limits<double>::quiet_NaN();
  const auto integrator = make_integrator({});
  Budget budget{.iterations = 5};

  const SolveReport report = integrator->advance(world, {}, 0.01, budget);

  CHECK_FALSE(report.converged);
  CHECK_FALSE(integrator->trial().is_finite);
}

TEST_CASE("What a step without a result has stopped does not run back in the next",
          "[bounded_step]") {
  bodies::World world = scene::build_world(sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, 0}, 0.01, 0.1), {1, 0, 0})}));
  const auto integrator = make_integrator({});
  const auto step = [&](int iterations) {
    Budget budget{.iterations = iterations};
    const SolveReport report = integrator->advance(world, {}, 0.01, budget);
    integrator->commit(world, 0.01);
    return report.converged;
  };
  for (int i = 0; i < 3; ++i) REQUIRE(step(10));
  world.gravity_m_s2.x() = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_FALSE(step(3));
  world.gravity_m_s2.x() = 0.0;

  for (int i = 0; i < 4; ++i) {
    CHECK(step(10));
    CHECK(world.rigid_bodies[0].velocity_m_s.norm() < 1e-12);
  }
}

TEST_CASE("A step cut short moves what nothing hinders as far as it would have gone",
          "[bounded_step]") {
  bodies::World world = scene::build_world(sim_server::scene_of(
      {sim_server::moving(sim_server::sphere({0, 0, 0}, 0.01, 0.1), {1, 0, 0})}, {},
      kGravity_m_s2));
  const auto integrator = make_integrator({});
  Budget budget{.iterations = 1};

  CHECK(integrator->advance(world, {}, 0.01, budget).converged);
  CHECK(integrator->trial().rigid_bodies[0].position_m.x() == Approx(0.01));
}

}  // namespace
}  // namespace stillgrid::dynamics::bounded_step_test
