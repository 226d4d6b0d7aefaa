#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/sim_server/dynamics/known_answers/slope.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::resting_test {
namespace {

// Faces meet in four spheres, 10 mm off the middle along both axes.
constexpr int kBlocks = 10;
constexpr double kEdge_m = 0.03, kWeight_N = 0.1 * 9.81, kArm_m = 0.01;
constexpr double kStiffness_N_per_m = 40000.0, kFace_N_per_m = 4.0 * kStiffness_N_per_m;

/// Ten blocks on a floor, just touching. Friction only holds the spheres on top of each other.
scene::SceneDescription stack_of_ten(double uppermost_off_m) {
  std::vector<bodies::BodyDescription> bodies{sim_server::floor_at(0.0)};
  for (int i = 0; i < kBlocks; ++i)
    bodies.push_back(
        sim_server::box({i + 1 == kBlocks ? uppermost_off_m : 0.0, 0, (i + 0.5) * kEdge_m},
                        Eigen::Vector3d::Constant(kEdge_m), 0.1, {2.0 * kArm_m, 0.005}));
  return sim_server::scene_of(bodies, sim_server::material_of(kStiffness_N_per_m, 5.0, 0.5),
                              {0, 0, -9.81});
}

/// How far the farthest block is from the column's axis.
double off_axis_m(const bodies::World& world) {
  double off_m = 0.0;
  for (const bodies::RigidBody& block : world.rigid_bodies)
    off_m = std::max(off_m, block.position_m.head<2>().norm());
  return off_m;
}

TEST_CASE("The stack of ten blocks is too stiff to buckle by its own weight", "[known_answers]") {
  // Joints of rotational stiffness c at distances h bear a column of w newtons a metre while
  // 7.84 c h > w L^3.
  const double joint_N_m_per_rad = kFace_N_per_m * kArm_m * kArm_m, length_m = kBlocks * kEdge_m;
  CHECK(7.84 * joint_N_m_per_rad * kEdge_m >
        4.0 * kWeight_N / kEdge_m * length_m * length_m * length_m);
}

TEST_CASE("In a stack of ten blocks each sinks by the weight that it carries", "[known_answers]") {
  Simulation simulation(stack_of_ten(0.0));

  REQUIRE(advance(simulation, 0.01, 2000));

  double height_m = -0.5 * kEdge_m, sum_m = 0.0;
  for (int i = 0; i < kBlocks; ++i) {
    const bodies::RigidBody& block = simulation.world().rigid_bodies[static_cast<std::size_t>(i)];
    const double depth_m = kEdge_m - (block.position_m.z() - height_m);
    CHECK(depth_m == Approx((kBlocks - i) * kWeight_N / kFace_N_per_m).epsilon(1e-5));
    height_m = block.position_m.z();
    sum_m += depth_m;
  }
  CHECK(sum_m == Approx(55.0 * kWeight_N / kFace_N_per_m).epsilon(1e-5));
  CHECK(off_axis_m(simulation.world()) < 1e-6);
}

/// When the stack, its uppermost block a micrometre out of line, is a tenth of a millimetre out;
/// ten minutes if never.
double leans_after_s(scene::IntegratorKind integrator) {
  scene::SceneDescription scene = stack_of_ten(1e-6);
  scene.method.integrator = integrator;
  Simulation simulation(scene);
  for (int i = 0; i < 60000 / kCut; ++i) {
    static_cast<void>(simulation.step(0.01, no_tool));
    if (!(off_axis_m(simulation.world()) < 1e-4)) return 0.01 * i;
  }
  return 600.0;
}

TEST_CASE("A stack that its stiffness holds stands for ten minutes by implicit Euler",
          "[known_answers][long]") {
  CHECK(leans_after_s(scene::IntegratorKind::kImplicitEuler) >= 600.0);
}

TEST_CASE("A stack that its stiffness holds stands for ten minutes by velocity Verlet",
          "[known_answers][long]") {
  CHECK(leans_after_s(scene::IntegratorKind::kVelocityVerlet) >= 600.0);
}

Slide implicit_slide(double angle_deg) {
  const Slide slide = slide_on(angle_deg, {}, 500, 2000);
  CHECK(std::abs(slide.across_m_s) < 1e-9);
  CHECK(std::abs(slide.off_m_s) < 1e-6);
  return slide;
}

TEST_CASE("A block slips on a slope if tan of its angle exceeds the friction, and only then",
          "[known_answers]") {
  // tan 16.699 deg = 0.3
  const double below_deg = GENERATE(16.0, 16.69), above_deg = GENERATE(16.71, 17.0);

  const Slide creeping = implicit_slide(below_deg), slipping = implicit_slide(above_deg);

  // It comes to rest: near the angle slowly, by g (mu cos - sin) = 0.0017 m/s^2.
  CHECK((creeping.velocity_m_s < 1e-9 || creeping.acceleration_m_s2 < -1e-3));
  CHECK(slipping.velocity_m_s > 1e-3);
  CHECK(slipping.acceleration_m_s2 > 1e-3);
}

TEST_CASE("On 30 degrees a block accelerates by g (sin - mu cos) = 2.35629 m/s^2",
          "[known_answers]") {
  CHECK(std::abs(implicit_slide(30.0).acceleration_m_s2 - 2.35629) < 2e-5);
}

TEST_CASE("On 10 degrees a block is held by implicit Euler, to the solver's tolerance",
          "[known_answers]") {
  const Slide slide = implicit_slide(10.0);

  CHECK(std::abs(slide.velocity_m_s) < 1e-7);
  CHECK(std::abs(slide.acceleration_m_s2) < 1e-6);
}

}  // namespace
}  // namespace stillgrid::dynamics::resting_test
