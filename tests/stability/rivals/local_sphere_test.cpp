#include "tests/laboratory/rivals/local_sphere.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/laboratory/rivals/rivals.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::laboratory::local_sphere_test {
namespace {

constexpr std::uint64_t kPeriod_ns = 33 * rendering::kMillisecond_ns;

TEST_CASE("A body that is one sphere is felt through its local sphere exactly, wherever the tool",
          "[local_sphere]") {
  const float radius_m = GENERATE(0.004F, 0.02F, 0.5F);
  rendering::PublishedScene scene(rendering::plain_scene(800.0F, 0.005F), {radius_m}, kPeriod_ns);
  const auto sphere = rival_named("sphere")->make();
  const double contact_distance_m = static_cast<double>(radius_m) + 0.005;
  const Eigen::Vector3d made_at = Eigen::Vector3d(1.0, 0.4, -0.3).normalized();
  scene.show({{0.0, 0.0, 0.0}}, 0);
  // Made before contact, from 1 mm away.
  static_cast<void>(
      sphere->render(scene.view(), {.position_m = (contact_distance_m + 0.001) * made_at}, 0));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int touching = 0;
  for (int i = 0; i < 200; ++i) {
    const double distance_m = contact_distance_m + 0.002 * any(random);
    const Eigen::Vector3d side =
        Eigen::Vector3d(any(random), any(random), any(random)).normalized();
    const Eigen::Vector3d law_N = 800.0 * std::max(0.0, contact_distance_m - distance_m) * side;
    const rendering::ToolForce by_sphere =
        sphere->render(scene.view(), {.position_m = distance_m * side}, 0).force;
    CHECK((by_sphere.force_N - law_N).norm() < 1e-4);  // floats of half a metre
    touching += by_sphere.contacts;
  }
  CHECK(touching > 50);
}

TEST_CASE("Off the place where it was made a local sphere errs with the square of the way",
          "[local_sphere]") {
  // A rod of 50 mm, of spheres so close that its ripple is nothing: straight along x.
  std::vector<Eigen::Vector3d> centres_m;
  for (int i = -60; i <= 60; ++i) centres_m.emplace_back(0.001 * i, 0.0, 0.0);
  rendering::PublishedScene scene(rendering::plain_scene(50.0F, 0.005F),
                                  std::vector<float>(centres_m.size(), 0.05F), kPeriod_ns);
  scene.show(centres_m, 0);
  const auto grid = rendering::make_renderer(display::Transition::kHold);
  const auto sphere = rival_named("sphere")->make();
  const double height_m = 0.055 - 0.001;
  const auto lift_error_N = [&](double along_m) {
    const rendering::ToolPose pose{.position_m = {along_m, 0.0, height_m}};
    return (sphere->render(scene.view(), pose, 0).force.force_N -
            grid->render(scene.view(), pose, 0).force.force_N)
        .z();
  };
  CHECK(std::abs(lift_error_N(0.0)) < 1e-6);
  const double at_1mm = lift_error_N(0.001), at_2mm = lift_error_N(0.002),
               at_4mm = lift_error_N(0.004);
  CHECK(at_2mm / at_1mm == Approx(4.0).epsilon(0.1));
  CHECK(at_4mm / at_2mm == Approx(4.0).epsilon(0.1));
  // Its curvature is the mean of none along the rod and one over the reach across it.
  const double force_N =
      grid->render(scene.view(), {.position_m = {0, 0, height_m}}, 0).force.force_N.z();
  CHECK(at_2mm < 0.0);
  CHECK(std::abs(at_2mm) < 0.1 * force_N);
}

TEST_CASE("A plane is felt through a local sphere as a plane", "[local_sphere]") {
  publication::StaticScene fixed = rendering::plain_scene(1000.0F, 0.005F);
  fixed.planes = {{{0.0F, 0.6F, 0.8F}, 0.0F, 0, 0}};
  rendering::PublishedScene scene(fixed, {}, kPeriod_ns);
  scene.show({}, 0);
  const auto grid = rendering::make_renderer(display::Transition::kHold);
  const auto sphere = rival_named("sphere")->make();
  for (const double x_m : {0.0, 0.005, 0.02}) {
    const rendering::ToolPose pose{.position_m = {x_m, 0.001 + 0.1 * x_m, 0.001}};
    CHECK((sphere->render(scene.view(), pose, 0).force.force_N -
           grid->render(scene.view(), pose, 0).force.force_N)
              .norm() < 1e-3);
  }
}

}  // namespace
}  // namespace stillgrid::laboratory::local_sphere_test
