// Implicit Euler: its own answers, and the laws that it keeps at any step.
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/sanitizer_cut.hpp"
#include "tests/shared/dynamics/implicit_scenes.hpp"

namespace stillgrid::dynamics::implicit_test {
namespace {

constexpr double kGravity_m_s2 = 9.81, kRadius_m = 0.01;

TEST_CASE("A fall by implicit Euler is that of its velocities at the end", "[dynamics]") {
  EngineScene scene;
  scene.with_gravity();
  scene.add_node(0.01, {0.0, 0.0, 0.0});
  scene.add_node(0.01, {0.0, 1.0, 0.0}, true);
  scene.add_ball(kRadius_m, {1.0, 0.0, 0.0});
  Engine engine = scene.engine(kImplicit);
  const double step_s = 0.01;
  run_implicit(engine, 1.0, step_s);
  const double expected_m = -kGravity_m_s2 * step_s * step_s * 0.5 * 100.0 * 101.0;
  CHECK(engine.state().node_position_m[0].z == Approx(expected_m).epsilon(1e-12));
  CHECK(engine.state().rigid_position_m[0].z == Approx(expected_m).epsilon(1e-12));
  CHECK(engine.state().node_position_m[1].z == 0.0);
}

TEST_CASE("An oscillator decays as implicit Euler says", "[dynamics]") {
  constexpr double kStiffness = 50.0, kDamping = 0.03, kMass_kg = 0.01;
  for (const double step_s : {0.001, 0.01, 0.033}) {
    EngineScene scene;
    const int pin = scene.add_node(kMass_kg, {0.0, 0.0, 0.0}, true);
    const int node = scene.add_node(kMass_kg, {0.1, 0.0, 0.0});
    scene.add_spring(pin, node, kStiffness, kDamping);
    scene.state.node_position_m[1].x += 0.01;
    Engine engine = scene.engine(kImplicit);
    double x = 0.01, v = 0.0;
    for (int k = 0; k < 50; ++k) {
      engine.step({}, step_s);
      v = (kMass_kg * v - step_s * kStiffness * x) /
          (kMass_kg + step_s * kDamping + step_s * step_s * kStiffness);
      x += step_s * v;
      REQUIRE(engine.state().node_position_m[1].x == Approx(0.1 + x).epsilon(1e-7));
    }
  }
}

TEST_CASE("A body that turns freely keeps its momentum and never gains energy", "[dynamics]") {
  for (const double step_s : {0.001, 0.01, 0.033}) {
    EngineScene scene;
    scene.add_rigid(0.1, {1e-5, 2e-5, 2.8e-5}, {0.0, 0.0, 0.0});
    scene.state.angular_velocity_rad_s[0] = {0.3, 14.0, 0.2};  // about the middle axis
    Engine engine = scene.engine(kImplicit);
    const auto momentum = [&] {
      const Eigen::Quaterniond q = engine.state().orientation[0].quaternion();
      const Eigen::Vector3d spin =
          q.conjugate() * engine.state().angular_velocity_rad_s[0].vector();
      return Eigen::Vector3d(q *
                             engine.description().rigid_bodies[0].inertia_kg_m2.cwiseProduct(spin));
    };
    const Eigen::Vector3d before = momentum();
    const double start_J = energy_J(engine);
    CHECK(largest_gain(engine, 3.0, step_s, start_J) < 1e-7);
    CHECK((momentum() - before).norm() < 1e-4 * before.norm());
  }
}

/// A grid of nodes with springs to all neighbours, also along diagonals.
EngineScene soft_block(double mass_kg, const Eigen::Vector3i& count, const Eigen::Vector3d& size_m,
                       double stiffness_N_per_m, double damping_N_s_per_m) {
  EngineScene scene;
  const int nodes = count.prod();
  const auto index = [&](const Eigen::Vector3i& at) {
    return (at.z() * count.y() + at.y()) * count.x() + at.x();
  };
  std::vector<Eigen::Vector3i> places;
  for (int z = 0; z < count.z(); ++z)
    for (int y = 0; y < count.y(); ++y)
      for (int x = 0; x < count.x(); ++x) places.emplace_back(x, y, z);
  for (const Eigen::Vector3i& at : places)
    scene.add_node(mass_kg / nodes,
                   at.cast<double>().cwiseProduct(size_m).cwiseQuotient(
                       (count - Eigen::Vector3i::Ones()).cwiseMax(1).cast<double>()));
  for (const Eigen::Vector3i& at : places)
    for (const Eigen::Vector3i& other : places)
      if (index(at) < index(other) && (at - other).cwiseAbs().maxCoeff() == 1)
        scene.add_spring(index(at), index(other), stiffness_N_per_m, damping_N_s_per_m);
  return scene;
}

TEST_CASE("A strongly damped block that turns never gains energy", "[dynamics]") {
  EngineScene scene = soft_block(0.0003754, {4, 2, 2}, {0.011, 0.008183, 0.009329}, 3491.0, 11.2);
  const Eigen::Vector3d spin_rad_s(5.0, -20.0, 12.0);
  for (std::size_t i = 0; i < scene.state.node_position_m.size(); ++i)
    scene.state.node_velocity_m_s[i] =
        Vector4(spin_rad_s.cross(scene.state.node_position_m[i].vector()));
  Engine engine = scene.engine(kImplicit);
  const double start_J = energy_J(engine);
  CHECK(largest_gain(engine, 0.5, 0.01, start_J) < 1e-6);
  CHECK(energy_J(engine) > 0.0);
}

/// A cloth that hangs by two corners and swings down.
EngineScene cloth(double stiffness_N_per_m, double damping_N_s_per_m) {
  EngineScene scene =
      soft_block(0.05, {8, 8, 1}, {0.14, 0.14, 0.0}, stiffness_N_per_m, damping_N_s_per_m);
  scene.with_gravity();
  scene.description.nodes[0].is_pinned = scene.description.nodes[7].is_pinned = true;
  return scene;
}

TEST_CASE("Implicit Euler tends to the small steps' motion in proportion to its step",
          "[dynamics]") {
  constexpr double kFine_s = 0.25e-3, kDuration_s = 0.2;
  const EngineScene scene = cloth(100.0, 0.05);
  Engine fine = scene.engine();
  for (int k = 0; k < std::lround(kDuration_s / kFine_s); ++k) fine.step({}, kFine_s);
  const auto error_m = [&](double step_s) {
    Engine engine = scene.engine(kImplicit);
    run_implicit(engine, kDuration_s, step_s);
    double square = 0.0;
    for (std::size_t i = 0; i < scene.state.node_position_m.size(); ++i)
      square += (engine.state().node_position_m[i] - fine.state().node_position_m[i])
                    .vector()
                    .squaredNorm();
    return std::sqrt(square / 64.0);
  };
  const double coarse_m = error_m(2e-3), middle_m = error_m(1e-3), small_m = error_m(0.5e-3);
  CAPTURE(coarse_m, middle_m, small_m);
  CHECK(coarse_m / middle_m == Approx(2.0).margin(0.35));
  CHECK(middle_m / small_m == Approx(2.0).margin(0.35));
}

TEST_CASE("A stiff cloth never gains energy at long steps", "[dynamics]") {
  const double scale_J = 0.05 * kGravity_m_s2 * 0.14;
  for (const double step_s : {0.001, 0.01, 0.033}) {
    Engine engine = cloth(1e5, 0.1).engine(kImplicit);
    CHECK(largest_gain(engine, 1.0 / tests::kCut, step_s, scale_J) < 1e-6);
    CHECK(engine.solve().converged);
  }
}

TEST_CASE("A chain on ball joints never gains energy at long steps", "[dynamics]") {
  constexpr double kLength_m = 0.02;
  EngineScene scene;
  scene.with_gravity();
  for (int k = 0; k < 5; ++k) {
    const int link = scene.add_block(0.01, {kLength_m, 0.01, 0.008}, {(k + 0.5) * kLength_m, 0, 0});
    Description::Joint joint;
    joint.a = {.rigid = link, .point_m = {-0.5 * kLength_m, 0.0, 0.0}};
    joint.b = {.rigid = link - 1, .point_m = {0.5 * kLength_m, 0.0, 0.0}};
    if (k == 0) joint.b.point_m.setZero();
    joint.stiffness_N_per_m = 1e4;
    joint.damping_N_s_per_m = 0.1;
    scene.description.joints.push_back(joint);
    for (int other = link + 1; other < 5; ++other)
      scene.description.apart.emplace_back(link, other);
  }
  const double scale_J = 0.05 * kGravity_m_s2 * 0.05;
  for (const double step_s : {0.001, 0.01, 0.033}) {
    Engine engine = scene.engine(kImplicit);
    CHECK(largest_gain(engine, 2.0, step_s, scale_J) < 1e-6);
    CHECK(engine.solve().converged);
    CHECK(engine.state().rigid_position_m[4].z < -0.04);
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::implicit_test
