// Contacts and friction by implicit Euler.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sanitizer_cut.hpp"
#include "tests/shared/dynamics/drawn_scene.hpp"
#include "tests/shared/dynamics/implicit_scenes.hpp"
#include "tests/sim_server/every_target.hpp"

namespace stillgrid::dynamics::implicit_contacts_test {
namespace {

constexpr double kGravity_m_s2 = 9.81, kRadius_m = 0.01;

double height_of(const Engine& engine, int rigid) {
  return engine.state().rigid_position_m[static_cast<std::size_t>(rigid)].z;
}

TEST_CASE("By implicit Euler a ball and a block are as deep as weight over stiffness",
          "[dynamics]") {
  for (const double step_s : {0.001, 0.01, 0.033}) {
    EngineScene scene;
    scene.with_gravity();
    scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
    const int ball = scene.add_ball(kRadius_m, {0.0, 0.0, kRadius_m});
    const int block = scene.add_block(0.02, {0.03, 0.05, 0.02}, {0.2, 0.0, 0.01});
    Engine engine = scene.engine(kImplicit);
    run_implicit(engine, 3.0, step_s);
    const double mass_kg = engine.description().rigid_bodies[0].mass_kg;
    CHECK(kRadius_m - height_of(engine, ball) ==
          Approx(mass_kg * kGravity_m_s2 / 1000.0).epsilon(1e-4));
    CHECK(0.01 - height_of(engine, block) == Approx(0.02 * kGravity_m_s2 / 4000.0).epsilon(1e-4));
    CHECK(engine.touching() == 5);
  }
}

TEST_CASE("By implicit Euler a stack of blocks stands", "[dynamics]") {
  for (const double step_s : {0.001, 0.01}) {
    EngineScene scene;
    scene.with_gravity();
    scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
    for (int k = 0; k < 4; ++k) scene.add_block(0.02, {0.04, 0.04, 0.02}, {0, 0, 0.01 + 0.02 * k});
    Engine engine = scene.engine(kImplicit);
    run_implicit(engine, 2.0, step_s);
    double height_m = 0.0;
    for (int k = 0; k < 4; ++k) {
      const double weight_N = 0.02 * (4 - k) * kGravity_m_s2;
      height_m += 0.02 - weight_N / 4000.0;
      CHECK(height_of(engine, k) == Approx(height_m - 0.01).margin(2e-6));
    }
    CHECK(engine.state().rigid_velocity_m_s[3].vector().norm() < 1e-5);
  }
}

/// Distance that a block slides down a slope within 0.5 s.
double slide_m(double friction, double slope_rad, double step_s) {
  EngineScene scene;
  scene.description.materials = {{1000.0, 2.0, friction}};
  scene.description.gravity_m_s2 =
      kGravity_m_s2 * Eigen::Vector3d(std::sin(slope_rad), 0.0, -std::cos(slope_rad));
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  scene.add_block(0.02, {0.04, 0.04, 0.01},
                  {0.0, 0.0, 0.005 - 0.02 * kGravity_m_s2 * std::cos(slope_rad) / 4000.0});
  Engine engine = scene.engine(kImplicit);
  run_implicit(engine, 0.5, step_s);
  return engine.state().rigid_position_m[0].x;
}

TEST_CASE("By implicit Euler a block sticks on a slope, and slides by Coulomb's law",
          "[dynamics]") {
  constexpr double kSlope_rad = 0.3;  // tangent 0.309
  for (const double step_s : {0.001, 0.01}) {
    CHECK(slide_m(0.35, kSlope_rad, step_s) < 1e-4);
    const double pull_m_s2 = kGravity_m_s2 * (std::sin(kSlope_rad) - 0.2 * std::cos(kSlope_rad));
    // Velocities at the end of steps lead further by half a step.
    const double expected_m = 0.5 * pull_m_s2 * 0.5 * (0.5 + step_s);
    CHECK(slide_m(0.2, kSlope_rad, step_s) == Approx(expected_m).epsilon(0.01));
  }
}

TEST_CASE("By implicit Euler no drawn scene gains energy", "[dynamics]") {
  int unsolved = 0, steps = 0;
  for (std::uint64_t seed = 30; seed < 30 + 30 / tests::kCut; ++seed)
    for (const double step_s : {0.001, 0.01, 0.033}) {
      const DrawnScene drawn(seed);
      Engine engine = drawn.scene.engine(kImplicit);
      DrivenPose away;
      away.is_here = false;
      double before_J = energy_J(engine);
      const double gain_J = 5e-5 * (0.001 + std::abs(before_J));  // of springs pushed aside
      for (int k = 0; k < std::lround(0.4 / step_s); ++k) {
        engine.step(std::span(&away, 1), step_s);
        const double now_J = energy_J(engine);
        INFO("seed " << seed << ", step " << k << " of " << step_s << " s");
        CHECK(now_J - before_J < gain_J);
        before_J = now_J;
        unsolved += engine.solve().converged ? 0 : 1;
        ++steps;
      }
    }
  CHECK(unsolved < std::max(2, steps / 1000));
}

TEST_CASE("By implicit Euler no ball passes through another, at any speed", "[dynamics]") {
  for (const double speed_m_s : {0.5, 2.0, 10.0, 50.0, 100.0})
    for (const double step_s : {0.001, 0.01, 0.033})
      for (const double aside_m : {0.0, 0.003, 0.009}) {
        EngineScene scene;
        scene.description.materials = {{1e6, 0.0, 0.0}};
        scene.add_ball(kRadius_m, {0.0, 0.0, 0.0});
        scene.add_ball(kRadius_m, {-0.05 - 0.1 * speed_m_s * step_s, aside_m, 0.0});
        scene.state.rigid_velocity_m_s[1] = {speed_m_s, 0.0, 0.0};
        Engine engine = scene.engine(kImplicit);
        run_implicit(engine, std::max(step_s, 0.2 / speed_m_s + step_s), step_s);
        INFO(speed_m_s << " m/s, " << step_s << " s, " << aside_m << " m aside");
        CHECK(engine.state().rigid_velocity_m_s[0].x > 0.05 * speed_m_s);
      }
}

TEST_CASE("By implicit Euler a ball falls, however fast a block whirls on the floor",
          "[dynamics]") {
  // 1e4 rad in a step: beyond all halvings.
  EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  const int block = scene.add_block(0.1, {0.02, 0.02, 0.02}, {0.0, 0.0, 0.00999});
  scene.state.angular_velocity_rad_s[static_cast<std::size_t>(block)] = {0.0, 0.0, 1e5};
  const int ball = scene.add_ball(kRadius_m, {3.0, 0.0, 2.0});
  Engine engine = scene.engine(kImplicit);
  engine.step({}, 0.1);
  CHECK(engine.solve().passes > 0);
  CHECK(engine.state().rigid_velocity_m_s[static_cast<std::size_t>(ball)].z ==
        Approx(-0.1 * kGravity_m_s2).epsilon(1e-6));
}

TEST_CASE("By implicit Euler a run through a saved block is equal to the bit, on every target",
          "[dynamics]") {
  const auto run = [](Engine& engine, const DrawnScene& drawn, int ticks) {
    for (int k = 0; k < ticks; ++k) {
      const DrivenPose pose = drawn.tool(engine.state().tick);
      engine.step(std::span(&pose, 1));
    }
  };
  std::vector<std::byte> half, end, other;
  for (std::uint64_t seed = 0; seed < 20 / tests::kCut; ++seed) {
    end.clear();
    sim_server::on_every_target([&] {
      const DrawnScene drawn(seed);
      Engine whole = drawn.scene.engine(kImplicit), second = drawn.scene.engine(kImplicit);
      run(whole, drawn, 60);
      whole.save(half);
      run(whole, drawn, 60);
      whole.save(other);
      if (!end.empty()) REQUIRE(other == end);
      run(second, drawn, 7);  // it has been somewhere else before
      second.load(half);
      run(second, drawn, 60);
      second.save(end);
      REQUIRE(other == end);
    });
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::implicit_contacts_test
