#include <catch2/catch.hpp>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::conservation_test {
namespace {

/// Per step, of the Newton solver's tolerance: residuals times scale, rms, stay below 1e-8.
constexpr double kTolerance = 1e-8;

Eigen::Matrix3d world_inertia(const bodies::RigidBody& body) {
  const Eigen::Matrix3d r = body.orientation.toRotationMatrix();
  return r * body.inertia_kg_m2.asDiagonal() * r.transpose();
}

Eigen::Vector3d momentum_N_s(const bodies::World& world) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const bodies::Node& node : world.nodes) sum += node.mass_kg * node.velocity_m_s;
  for (const bodies::RigidBody& body : world.rigid_bodies) sum += body.mass_kg * body.velocity_m_s;
  return sum;
}

Eigen::Vector3d angular_momentum(const bodies::World& world) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const bodies::RigidBody& body : world.rigid_bodies)
    sum += body.mass_kg * body.position_m.cross(body.velocity_m_s) +
           world_inertia(body) * body.angular_velocity_rad_s;
  return sum;
}

TEST_CASE("A free box keeps its angular momentum, however fast it tumbles", "[conservation]") {
  const Eigen::Vector3d spin_rad_s =
      GENERATE(Eigen::Vector3d(0, 0, 30), Eigen::Vector3d(0.3, 25, 0.1),  // the unstable axis
               Eigen::Vector3d(20, -15, 10));
  Simulation simulation(sim_server::scene_of(
      {sim_server::moving(sim_server::box({0, 0, 0}, {0.01, 0.03, 0.05}, 0.05, {0.01, 0.005}),
                          {0.1, 0.2, 0.3}, spin_rad_s)}));
  const bodies::RigidBody& body = simulation.world().rigid_bodies[0];
  // sqrt(6) equations of the residual in N m s: tolerance * I / reach each, and a
  // share for the turn of the inertia.
  const double allowed =
      1.01 * std::sqrt(6.0) * kTolerance * body.inertia_kg_m2.maxCoeff() / body.bounding_radius_m;

  Eigen::Vector3d before = world_inertia(body) * body.angular_velocity_rad_s;
  for (int i = 0; i < 300; ++i) {
    REQUIRE(advance(simulation, 0.033, 1));
    const Eigen::Vector3d now = world_inertia(body) * body.angular_velocity_rad_s;
    REQUIRE((now - before).norm() <= allowed);
    before = now;
  }
  CHECK((body.position_m - 9.9 * Eigen::Vector3d(0.1, 0.2, 0.3)).norm() < 1e-6);
}

TEST_CASE("What collides keeps its momentum, with friction, dampers and springs",
          "[conservation]") {
  bodies::BodyDescription cloth =
      sim_server::moving(sim_server::sheet({6, 6}, 0.02, 0.002, 500.0), {0, 0, 0.5}, {1, 2, 0});
  sim_server::shear_stiffness_N_per_m(cloth) = 250.0;
  sim_server::springs(cloth).spring_damping_N_s_per_m = 0.2;
  const bodies::SpherePacking packing{0.01, 0.005};
  const Eigen::Vector3d size_m(0.03, 0.03, 0.02);
  Simulation simulation(sim_server::scene_of(
      {cloth,
       sim_server::moving(sim_server::box({-0.02, 0, 0.04}, size_m, 0.02, packing), {0.1, 0, -0.3},
                          {3, 0, 9}),
       sim_server::moving(sim_server::box({0.02, 0.01, 0.05}, size_m, 0.03, packing),
                          {-0.2, 0, -0.4}, {0, 7, 0})},
      sim_server::material_of(500.0, 1.0, 0.4)));
  const Eigen::Vector3d momentum_before_N_s = momentum_N_s(simulation.world());

  int most_contacts = 0;
  for (int i = 0; i < 200; ++i) {
    const StepReport report = simulation.step(0.002, no_tool);
    most_contacts = std::max(most_contacts, report.contacts);
    REQUIRE(report.solve.converged);
  }

  REQUIRE(most_contacts > 5);
  // Contacts and springs cancel in every equation's sum, so only the solver's tolerance is left:
  // 1e-8 m/s a step of bodies of some 0.1 kg.
  CHECK((momentum_N_s(simulation.world()) - momentum_before_N_s).norm() < 2e-8);
}

/// Two spinning boxes that graze each other with friction. Returns the angular momentum gained, and
/// checks each step against what implicit Euler's arms account for.
Eigen::Vector3d gain_in_collision(double step_s) {
  const bodies::SpherePacking packing{0.01, 0.005};
  const Eigen::Vector3d size_m(0.03, 0.03, 0.02);
  Simulation simulation(sim_server::scene_of(
      {sim_server::moving(sim_server::box({0, 0, 0}, size_m, 0.02, packing), {0, 0, 0.3},
                          {2, 5, 1}),
       sim_server::moving(sim_server::box({0.012, 0.008, 0.035}, size_m, 0.03, packing),
                          {0.1, 0, -0.3}, {-4, 3, 7})},
      sim_server::material_of(500.0, 0.0, 0.4, 0.05)));
  bodies::World& world = simulation.world();
  const Eigen::Vector3d start = angular_momentum(world);
  // The twelve equations' residuals, as moments: of 30 g at 40 mm, the spins' I / reach being less.
  const double allowed = std::sqrt(12.0) * kTolerance * 0.03 * 0.04;
  bool touched = false;
  for (double time_s = 0.0; time_s < 0.1 - 1e-9; time_s += step_s) {
    const bodies::World before = world;
    const StepReport report = simulation.step(step_s, no_tool);
    REQUIRE(report.solve.converged);
    touched = touched || report.contacts > 0;
    // A force acts with the arm at the step's end but moves centres from the step's start:
    // dL = -h v1 x (m dv), summed over the bodies. Pressure acts with the mean arm of the turn, so
    // up to h w r / 2 beside the end's, and along the mean normal, which spheres of 5 mm turn by
    // h v / 10 mm.
    constexpr double kLongestArm_m = 0.025, kCentres_m = 0.01;
    Eigen::Vector3d expected = Eigen::Vector3d::Zero();
    double by_turn = 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
      const bodies::RigidBody& body = world.rigid_bodies[i];
      const Eigen::Vector3d impulse_N_s =
          body.mass_kg * (body.velocity_m_s - before.rigid_bodies[i].velocity_m_s);
      expected -= step_s * body.velocity_m_s.cross(impulse_N_s);
      const double turned_m = step_s * body.angular_velocity_rad_s.norm() * kLongestArm_m;
      const double moved_m = step_s * body.velocity_m_s.norm() + turned_m;
      by_turn += 0.5 * (turned_m + moved_m / kCentres_m * kLongestArm_m) * impulse_N_s.norm();
    }
    const Eigen::Vector3d gain = angular_momentum(world) - angular_momentum(before);
    CHECK((gain - expected).norm() < allowed + by_turn);
  }
  REQUIRE(touched);
  return angular_momentum(world) - start;
}

TEST_CASE("Colliding bodies keep their angular momentum but for implicit Euler's first order",
          "[conservation]") {
  const double coarse = gain_in_collision(4e-4).norm();
  const double fine = gain_in_collision(2e-4).norm();
  const double finest = gain_in_collision(1e-4).norm();

  CHECK(coarse / fine == Approx(2.0).epsilon(0.1));
  CHECK(fine / finest == Approx(2.0).epsilon(0.05));
}

}  // namespace
}  // namespace stillgrid::dynamics::conservation_test
