// The law of a contact: bounces, friction that turns with the bodies, order of convergence.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/shared/dynamics/implicit_scenes.hpp"

namespace stillgrid::dynamics::contact_law_test {
namespace {

constexpr double kGravity_m_s2 = 9.81, kRadius_m = 0.01;

/// Speed of a ball after a bounce on a plane without dampers, over the speed before. The ball meets
/// the plane at `phase` of a tick.
double bounce(double speed_m_s, double stiffness_N_per_m, double phase) {
  EngineScene scene;
  scene.description.materials = {{stiffness_N_per_m, 0.0, 0.0}};
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  scene.add_ball(kRadius_m, {0.0, 0.0, kRadius_m + speed_m_s * kTick_s * (1.0 + phase)});
  scene.state.rigid_velocity_m_s[0] = {0.0, 0.0, -speed_m_s};
  Engine engine = scene.engine();
  for (int k = 0; k < 40; ++k) engine.step();
  return engine.state().rigid_velocity_m_s[0].z / speed_m_s;
}

TEST_CASE("A bounce without dampers keeps the speed, at any phase of a tick", "[dynamics]") {
  constexpr int kPhases = 20;
  for (const double stiffness_N_per_m : {200.0, 1000.0, 20000.0})
    for (int k = 0; k < kPhases; ++k)
      CHECK(bounce(0.3, stiffness_N_per_m, k / double{kPhases}) == Approx(1.0).epsilon(1e-4));
}

/// A block rides on a turntable at 6 rad/s: the friction that holds it turns with both.
TEST_CASE("A block on a turntable stays in its place", "[dynamics]") {
  constexpr double kSpin_rad_s = 6.0, kDistance_m = 0.05, kTurns = 3.0;
  EngineScene scene;
  scene.with_gravity();
  scene.description.materials = {{200.0, 0.5, 0.9}};
  const int table = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), true);
  const Eigen::Vector3d size_m(0.03, 0.03, 0.02);
  const double rest_m = 0.02 * kGravity_m_s2 / (4.0 * 200.0);  // depth of its contacts
  (void)scene.add_block(0.02, size_m, {kDistance_m, 0.0, 0.02 - rest_m});
  for (const double x : {-0.01, 0.01})
    for (const double y : {-0.01, 0.01}) scene.add_sphere(table, 0.01, {kDistance_m + x, y, 0.0});
  scene.state.rigid_velocity_m_s[1] = {0.0, kSpin_rad_s * kDistance_m, 0.0};
  scene.state.angular_velocity_rad_s[1] = {0.0, 0.0, kSpin_rad_s};
  Engine engine = scene.engine(each_method());
  DrivenPose pose;
  double turn_rad = 0.0;
  const auto place_m = [&]() -> Eigen::Vector3d {  // in the frame of the table
    return pose.orientation.conjugate() * engine.state().rigid_position_m[1].vector();
  };
  const auto run = [&](double turns) {
    for (int k = 0; k < std::lround(turns * 2.0 * M_PI / (kSpin_rad_s * kTick_s)); ++k) {
      turn_rad += kSpin_rad_s * kTick_s;
      pose.orientation = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ());
      engine.step(std::span(&pose, 1));
    }
  };
  run(1.0);  // comes to rest
  const Eigen::Vector3d before_m = place_m();
  run(kTurns);
  CHECK((place_m() - before_m).norm() < 1e-5);  // 1e-3 if the stretch does not turn
}

/// Height of a ball that swings on a plane and never leaves it, after 0.2 s.
double swing_m(double tick_s, double damping_N_s_per_m) {
  EngineScene scene;
  scene.with_gravity();
  scene.description.materials = {{100.0, damping_N_s_per_m, 0.5}};
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  (void)scene.add_ball(kRadius_m, {0.0, 0.0, kRadius_m - 1e-5});
  scene.state.rigid_velocity_m_s[0] = {0.01, 0.0, 0.0};
  Engine engine = scene.engine();
  for (int k = 0; k < std::lround(0.2 / tick_s); ++k) engine.step({}, tick_s);
  return engine.state().rigid_position_m[0].z + engine.state().rigid_position_m[0].x;
}

TEST_CASE("Errors of a contact that lasts fall by four where ticks are halved", "[dynamics]") {
  for (const double damping_N_s_per_m : {0.0, 0.02}) {
    const double truth_m = swing_m(1.0 / 16000.0, damping_N_s_per_m);
    const double coarse_m = swing_m(1.0 / 1000.0, damping_N_s_per_m) - truth_m;
    const double fine_m = swing_m(1.0 / 2000.0, damping_N_s_per_m) - truth_m;
    INFO(damping_N_s_per_m << ": " << coarse_m << " m, " << fine_m << " m");
    CHECK(std::abs(fine_m) < std::abs(coarse_m) / 3.0);
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::contact_law_test
