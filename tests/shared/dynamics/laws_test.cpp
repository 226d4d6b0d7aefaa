// What a scene does by the laws of mechanics, whatever the engine computes inside.
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::dynamics::laws_test {
namespace {

constexpr double kGravity_m_s2 = 9.81, kRadius_m = 0.01;

void run(Engine& engine, double duration_s) {
  for (int k = 0; k < std::lround(duration_s / kTick_s); ++k) engine.step();
}
Eigen::Vector3d position_of(const Engine& engine, int rigid) {
  return engine.state().rigid_position_m[static_cast<std::size_t>(rigid)].vector();
}
Eigen::Vector3d velocity_of(const Engine& engine, int rigid) {
  return engine.state().rigid_velocity_m_s[static_cast<std::size_t>(rigid)].vector();
}

struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  double kinetic_J = 0.0;
};
Momenta momenta_of(const Engine& engine) {
  Momenta sum;
  const SceneState& state = engine.state();
  for (std::size_t r = 0; r < state.rigid_position_m.size(); ++r) {
    const Description::Rigid& body = engine.description().rigid_bodies[r];
    const Eigen::Vector3d v = state.rigid_velocity_m_s[r].vector();
    const Eigen::Vector3d w = state.angular_velocity_rad_s[r].vector();
    const Eigen::Matrix3d axes = state.orientation[r].quaternion().toRotationMatrix();
    const Eigen::Vector3d spin = axes * body.inertia_kg_m2.asDiagonal() * axes.transpose() * w;
    sum.linear += body.mass_kg * v;
    sum.angular += body.mass_kg * state.rigid_position_m[r].vector().cross(v) + spin;
    sum.kinetic_J += 0.5 * body.mass_kg * v.squaredNorm() + 0.5 * w.dot(spin);
  }
  return sum;
}

TEST_CASE("A ball at rest is as deep as its weight over the stiffness", "[dynamics]") {
  EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  const int ball = scene.add_ball(kRadius_m, {0.0, 0.0, kRadius_m});
  Engine engine = scene.engine();
  run(engine, 3.0);
  const double depth_m = kRadius_m - position_of(engine, ball).z();
  const double mass_kg = engine.description().rigid_bodies[0].mass_kg;
  CHECK(depth_m == Approx(mass_kg * kGravity_m_s2 / 1000.0).epsilon(1e-4));
}

TEST_CASE("A block at rest is borne by its spheres in equal parts", "[dynamics]") {
  EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  const Eigen::Vector3d size_m(0.03, 0.05, 0.02);
  const int block = scene.add_block(0.02, size_m, {0.0, 0.0, 0.5 * size_m.z()});
  Engine engine = scene.engine();
  run(engine, 3.0);
  const double depth_m = 0.5 * size_m.z() - position_of(engine, block).z();
  CHECK(depth_m == Approx(0.02 * kGravity_m_s2 / 4000.0).epsilon(1e-3));
  CHECK(engine.state().orientation[0].quaternion().angularDistance(Eigen::Quaterniond::Identity()) <
        1e-5);
}

TEST_CASE("Bodies that collide keep momentum, linear and angular", "[dynamics]") {
  EngineScene scene;
  const int ball = scene.add_ball(kRadius_m, {-0.04, 0.004, 0.002});
  const int block = scene.add_block(0.02, {0.03, 0.05, 0.02}, {0.0, 0.0, 0.0});
  const int other = scene.add_ball(0.008, {0.05, -0.006, 0.003});
  const auto set = [](std::vector<Vector4>& values, int body, Vector4 value) {
    values[static_cast<std::size_t>(body)] = value;
  };
  set(scene.state.rigid_velocity_m_s, ball, {0.4, 0.0, 0.0});
  set(scene.state.rigid_velocity_m_s, other, {-0.3, 0.02, 0.0});
  set(scene.state.angular_velocity_rad_s, ball, {0.0, 20.0, 5.0});
  set(scene.state.angular_velocity_rad_s, block, {1.0, 2.0, -3.0});
  Engine engine = scene.engine();
  const Momenta start = momenta_of(engine);
  run(engine, 0.5);
  const Momenta end = momenta_of(engine);
  CHECK(velocity_of(engine, ball).x() < 0.2);  // they did collide
  CHECK((end.linear - start.linear).norm() < 1e-6 * start.linear.norm());
  CHECK((end.angular - start.angular).norm() < 1e-4 * start.angular.norm());
  CHECK(end.kinetic_J < start.kinetic_J);
}

TEST_CASE("A body that spins freely keeps its angular momentum and its energy, however fast",
          "[dynamics]") {
  const double speed_rad_s = GENERATE(15.0, 150.0, 1500.0, 15'000.0, 150'000.0);
  EngineScene scene;
  (void)scene.add_block(0.02, {0.01, 0.05, 0.02}, Eigen::Vector3d::Zero());
  // About the unstable axis, nearly.
  scene.state.angular_velocity_rad_s[0] = speed_rad_s * Vector4(0.02, 0.03, 1.0);
  Engine engine = scene.engine();
  const Momenta start = momenta_of(engine);
  run(engine, 10.0);
  const Momenta end = momenta_of(engine);
  CHECK((end.angular - start.angular).norm() < 1e-9 * start.angular.norm());
  CHECK(end.kinetic_J == Approx(start.kinetic_J).epsilon(1e-9));
}

TEST_CASE("A body that spins freely turns as Euler's equations say", "[dynamics]") {
  const auto turned_after = [](double tick_s) {
    EngineScene scene;
    (void)scene.add_block(0.02, {0.01, 0.05, 0.02}, Eigen::Vector3d::Zero());
    scene.state.angular_velocity_rad_s[0] = {0.3, 0.4, 15.0};
    Engine engine = scene.engine();
    for (double at_s = 0.0; at_s < 1.0 - 1e-9; at_s += tick_s) engine.step({}, tick_s);
    return engine.state().orientation[0].quaternion();
  };
  const Eigen::Quaterniond truth = turned_after(0.0001);
  const double coarse_rad = turned_after(0.004).angularDistance(truth);
  const double fine_rad = turned_after(0.001).angularDistance(truth);
  CHECK(fine_rad < 1e-3);
  CHECK(coarse_rad / fine_rad == Approx(16.0).epsilon(0.1));  // second order
}

TEST_CASE("A ball pinched between walls is held by friction and does not creep", "[dynamics]") {
  EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d::UnitX(), 0.0);
  scene.add_plane(-Eigen::Vector3d::UnitX(), -(2.0 * kRadius_m - 2e-4));
  const int ball = scene.add_ball(kRadius_m, {kRadius_m - 1e-4, 0.0, 0.1});
  Engine engine = scene.engine();
  run(engine, 1.0);
  const double after_1_s = position_of(engine, ball).z();
  run(engine, 10.0);
  const double mass_kg = engine.description().rigid_bodies[0].mass_kg;
  CHECK(0.1 - after_1_s == Approx(mass_kg * kGravity_m_s2 / 2000.0).epsilon(0.03));
  CHECK(std::abs(after_1_s - position_of(engine, ball).z()) < 5e-7);
}

TEST_CASE("A block slides down a slope by gravity less friction", "[dynamics]") {
  constexpr double kFriction = 0.2, kSlope_rad = 0.4;
  EngineScene scene;
  scene.description.materials = {{2000.0, 5.0, kFriction}};
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  scene.description.gravity_m_s2 =
      kGravity_m_s2 * Eigen::Vector3d(std::sin(kSlope_rad), 0.0, -std::cos(kSlope_rad));
  const int block = scene.add_block(0.02, {0.03, 0.03, 0.01}, {0.0, 0.0, 0.005});
  Engine engine = scene.engine();
  run(engine, 0.2);
  const double before_m_s = velocity_of(engine, block).x();
  run(engine, 0.5);
  const double expected_m_s2 =
      kGravity_m_s2 * (std::sin(kSlope_rad) - kFriction * std::cos(kSlope_rad));
  CHECK((velocity_of(engine, block).x() - before_m_s) / 0.5 == Approx(expected_m_s2).epsilon(0.01));
}

TEST_CASE("Nodes on a spring swing at its frequency and keep their energy", "[dynamics]") {
  EngineScene scene;
  const int a = scene.add_node(0.01, {0.0, 0.0, 0.0}), b = scene.add_node(0.02, {0.1, 0.0, 0.0});
  scene.add_spring(a, b, 50.0);
  scene.state.node_position_m[1].x += 0.01;
  Engine engine = scene.engine();
  const double frequency_rad_s = std::sqrt(50.0 * (1.0 / 0.01 + 1.0 / 0.02));
  double worst = 0.0;
  for (int k = 1; k <= 2000; ++k) {
    engine.step();
    const double apart_m =
        (engine.state().node_position_m[1] - engine.state().node_position_m[0]).x;
    const double expected_m = 0.1 + 0.01 * std::cos(frequency_rad_s * k * kTick_s);
    worst = std::max(worst, std::abs(apart_m - expected_m));
  }
  // Position Verlet is ahead by (h w)^2 / 24 of the phase.
  const double turn = frequency_rad_s * kTick_s, phase_rad = turn * turn / 24.0 * 2000.0 * turn;
  CHECK(worst < 1.02 * phase_rad * 0.01);
  const Vector4& va = engine.state().node_velocity_m_s[0];
  const Vector4& vb = engine.state().node_velocity_m_s[1];
  CHECK(0.01 * va.x + 0.02 * vb.x == Approx(0.0).margin(1e-15));
}

TEST_CASE("A cloth hangs by its pinned nodes, and they bear the ball on it", "[dynamics]") {
  constexpr int kSide = 6;
  constexpr double kSpacing_m = 0.02;
  EngineScene scene;
  scene.with_gravity();
  const auto node = [](int row, int column) { return row * kSide + column; };
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      const bool is_edge = row % (kSide - 1) == 0 || column % (kSide - 1) == 0;
      scene.add_node(0.002, kSpacing_m * Eigen::Vector3d(column, row, 0.0), is_edge);
      scene.cover({node(row, column)}, 0.011, -1);
      if (column > 0) scene.add_spring(node(row, column - 1), node(row, column), 500.0, 0.2);
      if (row > 0) scene.add_spring(node(row - 1, column), node(row, column), 500.0, 0.2);
    }
  for (int i = 0; i < kSide * kSide; ++i)
    for (int j = i + 1; j < kSide * kSide; ++j) scene.description.apart_spheres.emplace_back(i, j);
  const double middle_m = 0.5 * (kSide - 1) * kSpacing_m;
  const int ball = scene.add_ball(0.015, {middle_m + 0.001, middle_m - 0.002, 0.027});
  Engine engine = scene.engine();
  run(engine, 4.0);
  CHECK(velocity_of(engine, ball).norm() < 0.02);  // it rolls a little still
  CHECK((position_of(engine, ball) - Eigen::Vector3d(middle_m, middle_m, 0.0)).norm() < 0.02);
}

/// Links on ball joints: from the place (0, 0, 0) of the world along x.
EngineScene chain_of(int links, double stiffness_N_per_m) {
  constexpr double kLength_m = 0.02;
  EngineScene scene;
  scene.with_gravity();
  for (int k = 0; k < links; ++k) {
    const int link = scene.add_block(0.01, {kLength_m, 0.01, 0.008}, {(k + 0.5) * kLength_m, 0, 0});
    Description::Joint joint;
    joint.a = {.rigid = link, .point_m = {-0.5 * kLength_m, 0.0, 0.0}};
    joint.b = {.rigid = link - 1, .point_m = {0.5 * kLength_m, 0.0, 0.0}};
    if (k == 0) joint.b.point_m.setZero();
    joint.stiffness_N_per_m = stiffness_N_per_m;
    scene.description.joints.push_back(joint);
    for (int other = link + 1; other < links; ++other)
      scene.description.apart.emplace_back(link, other);
  }
  return scene;
}
double joint_energy_J(const Engine& engine) {
  double sum_J = 0.0;
  const auto place = [&](const Description::JointEnd& end) -> Eigen::Vector3d {
    if (end.rigid < 0) return end.point_m;
    const auto r = static_cast<std::size_t>(end.rigid);
    return engine.state().rigid_position_m[r].vector() +
           engine.state().orientation[r].quaternion() * end.point_m;
  };
  for (const Description::Joint& joint : engine.description().joints)
    sum_J += 0.5 * joint.stiffness_N_per_m * (place(joint.a) - place(joint.b)).squaredNorm();
  return sum_J;
}

TEST_CASE("A chain that swings on ball joints keeps its energy", "[dynamics]") {
  Engine engine = chain_of(5, 1000.0).engine();
  const auto energy_J = [&] {
    double sum_J = momenta_of(engine).kinetic_J + joint_energy_J(engine);
    for (int link = 0; link < 5; ++link)
      sum_J += 0.01 * kGravity_m_s2 * position_of(engine, link).z();
    return sum_J;
  };
  const double start_J = energy_J(), scale_J = 0.05 * kGravity_m_s2 * 0.05;
  double worst_J = 0.0, lowest_m = 0.0;
  for (int k = 0; k < 3000; ++k) {
    engine.step();
    worst_J = std::max(worst_J, std::abs(energy_J() - start_J));
    lowest_m = std::min(lowest_m, position_of(engine, 4).z());
  }
  CHECK(worst_J < 0.03 * scale_J);
  CHECK(lowest_m < -0.08);
}

TEST_CASE("A joint holds a weight at its weight over the stiffness", "[dynamics]") {
  EngineScene scene = chain_of(1, 500.0);
  scene.description.joints[0].damping_N_s_per_m = 0.5;
  scene.description.joints[0].a.point_m.setZero();
  scene.description.joints[0].b.point_m = {0.01, 0.0, 0.0};
  Engine engine = scene.engine();
  run(engine, 3.0);
  CHECK(position_of(engine, 0).z() == Approx(-0.01 * kGravity_m_s2 / 500.0).epsilon(1e-6));
}

TEST_CASE("A driven body feels the weight that it carries", "[dynamics]") {
  EngineScene scene;
  scene.with_gravity();
  const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), {0.0, 0.0, 0.0}, true);
  scene.add_sphere(tool, 0.05);
  const int ball = scene.add_ball(kRadius_m, {0.0, 0.0, 0.0599});
  Engine engine = scene.engine();
  DrivenPose pose;
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  for (int k = 0; k < 300; ++k) {  // rises evenly, before the ball can roll off
    pose.position_m.z() = 1e-4 * k;
    engine.step(std::span(&pose, 1));
    if (k >= 200) impulse += engine.reactions()[0].impulse_N_s;
  }
  const double mass_kg = engine.description().rigid_bodies[1].mass_kg;
  CHECK(impulse.z() / 0.1 == Approx(-mass_kg * kGravity_m_s2).epsilon(1e-3));
  CHECK(velocity_of(engine, ball).z() == Approx(0.1).epsilon(1e-3));
}

TEST_CASE("A driven body that is away touches nothing", "[dynamics]") {
  EngineScene scene;
  const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), true);
  scene.add_sphere(tool, 0.05);
  const int ball = scene.add_ball(kRadius_m, {0.0, 0.0, 0.055});
  Engine engine = scene.engine();
  DrivenPose pose;
  pose.is_here = false;
  for (int k = 0; k < 10; ++k) engine.step(std::span(&pose, 1));
  CHECK(velocity_of(engine, ball).norm() == 0.0);
  pose.is_here = true;
  for (int k = 0; k < 10; ++k) engine.step(std::span(&pose, 1));
  CHECK(velocity_of(engine, ball).z() > 0.0);
}

TEST_CASE("A tool without a proxy drags by viscous friction below its slip speed", "[dynamics]") {
  constexpr double kSlip_m_s = 0.05, kSpeed_m_s = 0.01, kFriction = 0.5;
  EngineScene scene;
  const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), {0.0, 0.0, 0.0149}, true);
  scene.add_sphere(tool, 0.005);
  scene.description.spheres.back().is_tool = true;
  scene.description.spheres.back().tool_slip_speed_m_s = kSlip_m_s;
  const int plate = scene.add_rigid(1e6, Eigen::Vector3d::Constant(1e6), Eigen::Vector3d::Zero());
  scene.add_sphere(plate, kRadius_m);
  Engine engine = scene.engine();
  DrivenPose pose;
  pose.position_m = {-4.5 * kSpeed_m_s * kTick_s, 0.0,
                     0.0149};  // above the middle in the last tick
  for (int k = 0; k < 5; ++k) {
    pose.position_m.x() += kSpeed_m_s * kTick_s;
    engine.step(std::span(&pose, 1));
  }
  const Eigen::Vector3d impulse = engine.reactions()[0].impulse_N_s;
  CHECK(-impulse.x() / impulse.z() == Approx(kFriction * kSpeed_m_s / kSlip_m_s).epsilon(0.02));
}

}  // namespace
}  // namespace stillgrid::dynamics::laws_test
