#include "sim_server/dynamics/forces/mechanical_system.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "sim_server/dynamics/forces/implicit_stage.hpp"
#include "tests/sim_server/contact/all_contacts.hpp"
#include "tests/sim_server/dynamics/dense_jacobian.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::mechanical_system_test {
namespace {

constexpr double kStep_s = 0.02;

enum class Kind { kMoving, kStill, kPlane, kTool, kAll };

/// A joint of every two sorts of ends: a node, a rigid body, the world. None is at rest.
std::vector<bodies::Joint> joints() {
  const bodies::JointEnd world{.point_m = {0.01, 0.0, 0.01}};
  const bodies::JointEnd one{.body = 1, .rigid = 0, .point_m = {0.012, -0.01, 0.004}};
  const bodies::JointEnd two{.body = 2, .rigid = 1, .point_m = {-0.01, 0.015, 0.008}};
  const auto node = [](int number) { return bodies::JointEnd{.body = 0, .node = number}; };
  return {{one, two, 0.0, 400.0, 0.7},         {one, world, 0.0, 300.0, 0.5},
          {node(7), two, 0.0, 500.0, 0.3},     {node(8), world, 0.0, 200.0, 0.4},
          {node(6), node(13), 0.0, 90.0, 0.2}, {node(1), node(17), 0.05, 80.0, 0.1}};
}

/// A crumpled sheet, two boxes in it and in each other, a post, a floor: everything overlaps, and
/// much is joined.
bodies::World tangle(const scene::MaterialDescription& material) {
  bodies::BodyDescription cloth = sim_server::sheet({5, 4}, 0.02, 0.002, 500.0);
  sim_server::shear_stiffness_N_per_m(cloth) = 250.0;
  sim_server::springs(cloth).bend_stiffness_N_per_m = 100.0;
  sim_server::springs(cloth).spring_damping_N_s_per_m = 0.3;
  sim_server::packing(cloth) = {0.013, 0.009};
  sim_server::springs(cloth).pinned_nodes = {0, 4};
  const Eigen::Vector3d size_m(0.03, 0.04, 0.02);
  bodies::BodyDescription one = sim_server::box({0.0, 0.0, 0.012}, size_m, 0.02, {0.01, 0.006});
  bodies::BodyDescription two = sim_server::box({0.012, 0.014, 0.02}, size_m, 0.03, {0.01, 0.006});
  one.orientation = Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized());
  two.orientation = Eigen::AngleAxisd(2.5, Eigen::Vector3d(3, -1, 2).normalized());
  bodies::BodyDescription post = sim_server::sphere({-0.02, 0.01, 0.0}, 0.02, 0.0);
  post.motion = bodies::Motion::kStatic;
  bodies::World world = scene::build_world(sim_server::scene_of(
      {cloth, one, two, post, sim_server::floor_at(0.002)}, material, {0.0, 0.0, -9.81}));

  std::mt19937 random(7);
  std::uniform_real_distribution<double> shake_m(-0.005, 0.005);
  for (bodies::Node& node : world.nodes)
    if (node.unknown != bodies::kNoUnknown)
      node.position_m += Eigen::Vector3d(shake_m(random), shake_m(random), shake_m(random));
  world.joints = joints();
  return world;
}

Eigen::VectorXd random_velocities(const bodies::World& world) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> speed(-0.5, 0.5);
  Eigen::VectorXd u(world.unknown_count);
  for (double& value : u) value = speed(random);
  for (const bodies::RigidBody& body : world.rigid_bodies) u.segment<3>(body.unknown + 3) *= 30.0;
  return u;
}

/// All contacts of one kind, begun at various depths so that some deepen and some let go.
std::vector<contact::Contact> contacts_of(const bodies::World& world, Kind kind) {
  const std::vector<contact::Contact> all = contact::contacts_within(
      world, kStep_s,
      {{Eigen::Vector3d(0.01, -0.01, 0.03), {0.3, 0.2, -0.5}, {0.01, -0.01, 0.04}, 0.02}});
  std::vector<contact::Contact> chosen;
  for (std::size_t i = 0; i < all.size(); ++i) {
    contact::Contact contact = all[i];
    contact.depth_before_m += 0.008 * std::sin(static_cast<double>(i));
    const Kind its = contact.is_tool    ? Kind::kTool
                     : contact.b >= 0   ? Kind::kMoving
                     : contact.is_plane ? Kind::kPlane
                                        : Kind::kStill;
    if (kind == Kind::kAll || kind == its) chosen.push_back(contact);
  }
  return chosen;
}

/// Of each contact, up to where it slides.
std::vector<Eigen::Vector3d> stretches_of(const std::vector<contact::Contact>& contacts) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> stretch_m(-0.002, 0.002);
  std::vector<Eigen::Vector3d> stretches_m(contacts.size());
  for (Eigen::Vector3d& own_m : stretches_m)
    own_m = {stretch_m(random), stretch_m(random), stretch_m(random)};
  return stretches_m;
}

Eigen::MatrixXd jacobian_at(ImplicitStage& step, const Eigen::VectorXd& u, JacobianKind kind) {
  Eigen::VectorXd residual(u.size());
  step.residual(u, residual);
  return dense_jacobian(step, kind);
}

TEST_CASE("The exact Jacobian is the derivative of the residual", "[mechanical_system]") {
  // A slip speed of 1 mm/s has all contacts slide, one of 30 m/s has all of them creep.
  const double slip_speed_m_s = GENERATE(1e-3, 30.0);
  const Kind kind = GENERATE(Kind::kMoving, Kind::kStill, Kind::kPlane, Kind::kTool, Kind::kAll);
  const bodies::World world = tangle(sim_server::material_of(900.0, 2.0, 0.4, slip_speed_m_s));
  const std::vector<contact::Contact> contacts = contacts_of(world, kind);
  MechanicalSystem system;
  const bool sticks = GENERATE(false, true);
  const std::vector<Eigen::Vector3d> stretches_m =
      sticks ? stretches_of(contacts) : std::vector<Eigen::Vector3d>();
  system.take(world, contacts, stretches_m, GENERATE(Levers::kAtEnd, Levers::kMean));
  ImplicitStage step(system, kStep_s);
  const Eigen::VectorXd u = random_velocities(world);
  const Eigen::MatrixXd exact = jacobian_at(step, u, JacobianKind::kExact);
  REQUIRE(system.trial().touching >= 3);

  constexpr double kChange = 1e-6;
  Eigen::VectorXd more(u.size()), less(u.size());
  double worst = 0.0;
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const Eigen::VectorXd change = kChange * Eigen::VectorXd::Unit(u.size(), i);
    step.residual(u + change, more);
    step.residual(u - change, less);
    const Eigen::VectorXd column = (more - less) / (2.0 * kChange);
    worst = std::max(worst, (column - exact.col(i)).norm() / exact.col(i).norm());
  }
  CHECK(worst < 1e-6);
}

TEST_CASE("The definite slope is symmetric and positive definite in any state",
          "[mechanical_system]") {
  const double slip_speed_m_s = GENERATE(1e-3, 30.0);
  const bodies::World world = tangle(sim_server::material_of(900.0, 2.0, 0.4, slip_speed_m_s));
  const std::vector<contact::Contact> contacts = contacts_of(world, Kind::kAll);
  MechanicalSystem system(world, contacts);
  ImplicitStage step(system, kStep_s);

  const Eigen::MatrixXd definite =
      jacobian_at(step, random_velocities(world), JacobianKind::kDefinite);

  CHECK((definite - definite.transpose()).norm() < 1e-14 * definite.norm());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(definite);
  // No less than the inertia alone: what it leaves out can only have softened.
  double least_inertia = 1.0;
  for (const bodies::RigidBody& body : world.rigid_bodies)
    least_inertia = std::min(least_inertia, body.inertia_kg_m2.minCoeff());
  CHECK(solver.eigenvalues().minCoeff() > 0.999 * least_inertia);
}

TEST_CASE("The symmetric slope is the definite one less what softens", "[mechanical_system]") {
  const bodies::World world =
      tangle(sim_server::material_of(900.0, 2.0, 0.4, GENERATE(1e-3, 30.0)));
  const std::vector<contact::Contact> contacts = contacts_of(world, Kind::kAll);
  MechanicalSystem system(world, contacts);
  ImplicitStage step(system, kStep_s);
  const Eigen::VectorXd u = random_velocities(world);

  const Eigen::MatrixXd symmetric = jacobian_at(step, u, JacobianKind::kSymmetric);

  CHECK((symmetric - symmetric.transpose()).norm() < 1e-14 * symmetric.norm());
  const Eigen::MatrixXd softening = jacobian_at(step, u, JacobianKind::kDefinite) - symmetric;
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(softening).eigenvalues();
  CHECK(values.minCoeff() > -1e-12 * symmetric.norm());
  CHECK(values.maxCoeff() > 1e-3);
}

TEST_CASE(
    "Of masses and springs at rest, pressed on each other without friction, the symmetric "
    "slope is exact",
    "[mechanical_system]") {
  bodies::World world = tangle(sim_server::material_of(900.0));
  world.joints.clear();
  std::vector<contact::Contact> contacts = contacts_of(world, Kind::kAll);
  const auto is_rigid = [&](int sphere) {
    return sphere >= 0 && world.spheres[static_cast<std::size_t>(sphere)].rigid >= 0;
  };
  std::erase_if(contacts,
                [&](const contact::Contact& own) { return is_rigid(own.a) || is_rigid(own.b); });
  MechanicalSystem system(world, contacts);
  ImplicitStage step(system, kStep_s);
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(system.size());

  const Eigen::MatrixXd exact = jacobian_at(step, still, JacobianKind::kExact);

  REQUIRE(system.trial().touching >= 3);
  CHECK((exact - jacobian_at(step, still, JacobianKind::kSymmetric)).norm() < 1e-14 * exact.norm());
  CHECK((exact - jacobian_at(step, still, JacobianKind::kDefinite)).norm() > 1e-3 * exact.norm());
}

TEST_CASE("The diagonal blocks are those of the slope, whoever sleeps", "[mechanical_system]") {
  bodies::World world = tangle(sim_server::material_of(900.0, 2.0, 0.4, GENERATE(1e-3, 30.0)));
  const int is_sleeping = GENERATE(-1, 0, 1);  // nobody, the cloth, a box
  if (is_sleeping >= 0) world.bodies[static_cast<std::size_t>(is_sleeping)].is_sleeping = true;
  bodies::number_unknowns(world);
  const std::vector<contact::Contact> contacts = contacts_of(world, Kind::kAll);
  const std::vector<Eigen::Vector3d> stretches_m = stretches_of(contacts);
  MechanicalSystem system;
  system.take(world, contacts, stretches_m, Levers::kMean);
  ImplicitStage step(system, kStep_s);
  const Eigen::VectorXd u = Eigen::VectorXd::Random(system.size());
  const JacobianKind kind =
      GENERATE(JacobianKind::kExact, JacobianKind::kSymmetric, JacobianKind::kDefinite);

  const Eigen::MatrixXd matrix = jacobian_at(step, u, kind);

  REQUIRE(step.block_diagonal().cols() == system.size());
  for (Eigen::Index i = 0; i < system.size(); i += 3)
    CHECK((step.block_diagonal().middleCols<3>(i) - matrix.block<3, 3>(i, i)).norm() <
          1e-13 * matrix.norm());
}

TEST_CASE("Where nothing softens both slopes are one", "[mechanical_system]") {
  const bodies::World world = scene::build_world(
      sim_server::scene_of({sim_server::thread(6, {0, 0, 0}, {0.5, 0, 0}, 0.01, 100.0, {0})}));
  MechanicalSystem system(world, {});
  ImplicitStage step(system, kStep_s);
  Eigen::VectorXd stretching = Eigen::VectorXd::Zero(world.unknown_count);
  for (Eigen::Index i = 0; i < 5; ++i) stretching[3 * i] = double(i + 1);

  const Eigen::MatrixXd exact = jacobian_at(step, stretching, JacobianKind::kExact);

  CHECK((exact - jacobian_at(step, stretching, JacobianKind::kDefinite)).norm() <
        1e-15 * exact.norm());
}

TEST_CASE("Free fall solves the step exactly", "[mechanical_system]") {
  const bodies::World world = scene::build_world(sim_server::scene_of(
      {sim_server::moving(sim_server::box({0, 0, 1}, {0.1, 0.1, 0.1}, 1.0, {0.1, 0.05}), {1, 2, 3}),
       sim_server::thread(3, {0, 0, 0}, {1, 0, 0}, 0.1, 50.0)},
      {}, {0.0, 0.0, -9.81}));
  MechanicalSystem system(world, {});
  ImplicitStage step(system, kStep_s);
  Eigen::VectorXd u = step.initial_guess();
  for (const bodies::Node& node : world.nodes) u[node.unknown + 2] -= kStep_s * 9.81;
  for (const bodies::RigidBody& body : world.rigid_bodies) u[body.unknown + 2] -= kStep_s * 9.81;
  Eigen::VectorXd residual(u.size());

  step.residual(u, residual);

  CHECK(residual.norm() < 1e-15);
}

TEST_CASE("A step has moved by its end velocities", "[mechanical_system]") {
  const bodies::World start = tangle(sim_server::material_of(900.0));
  const std::vector<contact::Contact> contacts = contacts_of(start, Kind::kAll);
  MechanicalSystem system(start, contacts);
  ImplicitStage step(system, kStep_s);
  const Eigen::VectorXd u = random_velocities(start);
  Eigen::VectorXd residual(u.size());
  step.residual(u, residual);
  bodies::World end = start;
  end.nodes = system.trial().nodes;
  end.rigid_bodies = system.trial().rigid_bodies;

  for (std::size_t i = 0; i < end.nodes.size(); ++i) {
    const Eigen::Vector3d move_m = end.nodes[i].position_m - start.nodes[i].position_m;
    CHECK((move_m - kStep_s * end.nodes[i].velocity_m_s).norm() < 1e-15);
    if (end.nodes[i].unknown == bodies::kNoUnknown) CHECK(move_m.isZero(0.0));
  }
  for (std::size_t i = 0; i < end.rigid_bodies.size(); ++i) {
    const bodies::RigidBody& body = end.rigid_bodies[i];
    const Eigen::AngleAxisd turn(body.orientation * start.rigid_bodies[i].orientation.conjugate());
    CHECK((turn.angle() * turn.axis() - kStep_s * u.segment<3>(body.unknown + 3)).norm() < 1e-13);
    CHECK(body.orientation.norm() == Approx(1.0).epsilon(1e-15));
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::mechanical_system_test
