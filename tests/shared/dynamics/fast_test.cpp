#include <catch2/catch.hpp>

#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::dynamics::fast_test {
namespace {

constexpr double kRadius_m = 0.005;

/// A sheet of balls across x, 9 x 9, that touch each other.
void add_sheet(EngineScene& scene) {
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j)
      scene.add_ball(kRadius_m, {0.0, 2.0 * kRadius_m * i, 2.0 * kRadius_m * j});
}
double momentum_x(const Engine& engine) {
  double sum = 0.0;
  for (std::size_t r = 0; r < engine.description().rigid_bodies.size(); ++r)
    sum += engine.description().rigid_bodies[r].mass_kg * engine.state().rigid_velocity_m_s[r].x;
  return sum;
}

TEST_CASE("A ball at 50 m/s does not pass through a sheet of balls unfelt", "[fast]") {
  const double phase_m = GENERATE(0.0, 0.009, 0.021, 0.034);
  EngineScene scene;
  scene.description.materials = {{2e4, 0.0, 0.0}};
  add_sheet(scene);
  const auto ball = static_cast<std::size_t>(scene.add_ball(kRadius_m, {-0.3 + phase_m, 0.0, 0.0}));
  scene.state.rigid_velocity_m_s[ball] = {50.0, 0.0, 0.0};
  Engine engine = scene.engine();
  const double before = momentum_x(engine);
  int most = 0;
  for (int tick = 0; tick < 12; ++tick) {
    engine.step();
    most = std::max(most, engine.substeps());
    if (tick < 3) CHECK(engine.substeps() == 1);  // it flies
  }
  CHECK(most == 40);
  CHECK(momentum_x(engine) == Approx(before).epsilon(1e-5));
  CHECK(engine.state().rigid_velocity_m_s[ball].x < 5.0);  // the ball in the middle took it over
  CHECK(engine.substeps() == 1);
}

TEST_CASE("Two balls at 50 m/s meet as well as slow ones", "[fast]") {
  const double phase_m = GENERATE(0.0, 0.013, 0.041);
  EngineScene scene;
  scene.description.materials = {{1e5, 0.0, 0.0}};
  const auto a = static_cast<std::size_t>(scene.add_ball(kRadius_m, {-0.2 - phase_m, 0.0, 0.0}));
  const auto b = static_cast<std::size_t>(scene.add_ball(kRadius_m, {0.2, 0.0, 0.0}));
  scene.state.rigid_velocity_m_s[a] = {50.0, 0.0, 0.0};
  scene.state.rigid_velocity_m_s[b] = {-50.0, 0.0, 0.0};
  Engine engine = scene.engine();
  for (int tick = 0; tick < 12; ++tick) engine.step();
  // At 64 substeps they come nearer by 0.3 radii at a time.
  CHECK(engine.state().rigid_velocity_m_s[a].x == Approx(-50.0).epsilon(0.1));
  CHECK(engine.state().rigid_velocity_m_s[b].x == Approx(50.0).epsilon(0.1));
}

TEST_CASE("A ball that a fast one strikes strikes others in the same tick", "[fast]") {
  // The struck ball crosses four radii to the next, outside of what was listed for it at rest.
  EngineScene scene;
  scene.description.materials = {{2e4, 0.0, 0.0}};
  const auto first = static_cast<std::size_t>(scene.add_ball(kRadius_m, {-0.02, 0.0, 0.0}));
  scene.state.rigid_velocity_m_s[first] = {50.0, 0.0, 0.0};
  const auto last = static_cast<std::size_t>([&] {
    scene.add_ball(kRadius_m, {0.0, 0.0, 0.0});
    return scene.add_ball(kRadius_m, {0.03, 0.0, 0.0});
  }());
  Engine engine = scene.engine();
  engine.step();
  engine.step();
  CHECK(engine.state().rigid_velocity_m_s[last].x > 45.0);
  CHECK(engine.listing().listings() > 1);
}

TEST_CASE("Balls that fly side by side, or past each other, are not divided", "[fast]") {
  EngineScene scene;
  const double speed_m_s = GENERATE(50.0, -50.0);
  for (int k = 0; k < 4; ++k) {
    const auto ball =
        static_cast<std::size_t>(scene.add_ball(kRadius_m, {0.1 * (k % 2), 0.0102 * k, 0.0}));
    scene.state.rigid_velocity_m_s[ball] = {k == 0 ? speed_m_s : 50.0, 0.0, 0.0};
  }
  Engine engine = scene.engine();
  for (int tick = 0; tick < 10; ++tick) {
    engine.step();
    CHECK(engine.substeps() == 1);
  }
}

TEST_CASE("A tool at 20 m/s strikes a ball on its way", "[fast]") {
  const double phase_m = GENERATE(0.0, 0.007, 0.014);
  EngineScene scene;
  scene.description.materials = {{2e4, 0.0, 0.0}};
  const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), {-0.1 - phase_m, 0.0, 0.0}, true);
  scene.add_sphere(tool, 0.004);
  scene.description.spheres.back().is_tool = true;
  const auto ball = static_cast<std::size_t>(scene.add_ball(kRadius_m, {0.0, 0.0, 0.0}));
  Engine engine = scene.engine();
  for (int tick = 1; tick <= 8; ++tick) {
    DrivenPose pose;
    pose.position_m = {-0.1 - phase_m + 0.02 * tick, 0.0, 0.0};
    engine.step(std::vector{pose});
  }
  CHECK(engine.state().rigid_velocity_m_s[ball].x == Approx(40.0).epsilon(0.05));
}

}  // namespace
}  // namespace stillgrid::dynamics::fast_test
