#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/sim_server/dynamics/known_answers/slope.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid {
namespace {

TEST_CASE("In a stack of ten blocks each sinks by the weight that it carries", "[known_answers]") {
  // Faces meet in four spheres of 1250 N/m each: 5000 N/m.
  constexpr int kBlocks = 10;
  constexpr double kEdge_m = 0.03, kWeight_N = 0.1 * 9.81;
  std::vector<BodyDescription> bodies{floor_at(0.0)};
  for (int i = 0; i < kBlocks; ++i)
    bodies.push_back(
        box({0, 0, (i + 0.5) * kEdge_m}, {kEdge_m, kEdge_m, kEdge_m}, 0.1, {0.02, 0.005}));
  // Friction only holds the spheres on top of each other; nothing slips.
  Simulation simulation(scene_of(bodies, material_of(1250.0, 0.0, 0.5), {0, 0, -9.81}));

  // Not by long steps: regularised friction creeps, and by steps of a second the stack topples from
  // a push of 0.1 nm, as spheres on spheres do, whether Newton's slopes are symmetric or exact.
  REQUIRE(advance(simulation, 0.01, 400));

  double height_m = -0.5 * kEdge_m, sum_m = 0.0;
  for (int i = 0; i < kBlocks; ++i) {
    const RigidBody& block = simulation.world().rigid_bodies[static_cast<std::size_t>(i)];
    const double depth_m = kEdge_m - (block.position_m.z() - height_m);
    CHECK(depth_m == Approx((kBlocks - i) * kWeight_N / 5000.0).epsilon(1e-5));
    CHECK(block.position_m.head<2>().norm() < 1e-6);
    if (i == 0) CHECK(std::abs(depth_m - 0.001962) < 5e-7);
    height_m = block.position_m.z();
    sum_m += depth_m;
  }
  CHECK(std::abs(sum_m - 0.010791) < 5e-7);
}

Slide implicit_slide(double angle_deg, IntegratorKind integrator = IntegratorKind::kImplicitEuler) {
  const Slide slide = slide_on(angle_deg, {.integrator = integrator}, 500, 2000);
  CHECK(std::abs(slide.across_m_s) < 1e-9);
  CHECK(std::abs(slide.off_m_s) < 1e-6);
  return slide;
}

IntegratorKind any_implicit() {
  return GENERATE(IntegratorKind::kImplicitEuler, IntegratorKind::kBdf2,
                  IntegratorKind::kTrapezoid);
}

TEST_CASE("A block slips on a slope if tan of its angle exceeds the friction, and only then",
          "[known_answers]") {
  // tan 16.699 deg = 0.3
  const double below_deg = GENERATE(16.0, 16.69), above_deg = GENERATE(16.71, 17.0);

  const Slide creeping = implicit_slide(below_deg), slipping = implicit_slide(above_deg);

  CHECK(creeping.velocity_m_s < 1e-3);
  CHECK(std::abs(creeping.acceleration_m_s2) < 1e-6);
  CHECK(slipping.velocity_m_s > 1e-3);
  CHECK(slipping.acceleration_m_s2 > 1e-3);
}

TEST_CASE("On 30 degrees a block accelerates by g (sin - mu cos) = 2.35629 m/s^2",
          "[known_answers]") {
  CHECK(std::abs(implicit_slide(30.0, any_implicit()).acceleration_m_s2 - 2.35629) < 5e-6);
}

TEST_CASE("On 10 degrees a block creeps at slip speed times tan / mu = 0.58776 mm/s",
          "[known_answers]") {
  const Slide slide = implicit_slide(10.0);

  CHECK(std::abs(slide.velocity_m_s - 0.58776e-3) < 5e-9);
  CHECK(std::abs(slide.acceleration_m_s2) < 1e-6);
}

}  // namespace
}  // namespace stillgrid
