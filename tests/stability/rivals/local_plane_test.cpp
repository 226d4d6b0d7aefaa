#include "tests/laboratory/rivals/local_plane.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "tests/laboratory/rivals/local_model_renderer.hpp"
#include "tests/laboratory/rivals/rivals.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::laboratory::local_plane_test {
namespace {

constexpr double kStiffness_N_per_m = 500.0;
constexpr double kJump_m = 0.0033;  // 0.1 m/s over 33 ms

/// The force on a still probe, tick by tick from the switch on, when a sphere of 100 mm has jumped
/// towards it; first the force before.
std::vector<double> forces_round_a_jump_N(double recovery_s, double depth_m) {
  rendering::PublishedScene scene(rendering::plain_scene(500.0F, 0.005F), {0.1F},
                                  33 * rendering::kMillisecond_ns);
  LocalModelRenderer renderer(std::make_unique<LocalPlane>(recovery_s));
  const rendering::ToolPose probe{.position_m = {0.105 - depth_m, 0.0, 0.0}};
  scene.show({{0.0, 0.0, 0.0}}, 0);
  static_cast<void>(renderer.render(scene.view(), probe, 0));  // the first plane recovers as well
  std::vector<double> forces_N{
      renderer.render(scene.view(), probe, 32 * rendering::kMillisecond_ns).force.force_N.x()};
  for (std::uint64_t ms = 33; ms < 66; ++ms) {
    if (ms == 33) scene.show({{kJump_m, 0.0, 0.0}}, 33 * rendering::kMillisecond_ns);
    const rendering::RenderedTick tick =
        renderer.render(scene.view(), probe, ms * rendering::kMillisecond_ns);
    if (ms == 33)
      CHECK(*tick.switch_jump_N ==
            Approx(std::abs(tick.force.force_N.x() - forces_N[0])).margin(1e-9));
    forces_N.push_back(tick.force.force_N.x());
  }
  return forces_N;
}

TEST_CASE("A recovering plane's jump is spread over ten ticks, without recovery it is K times it",
          "[local_plane]") {
  const double depth_m = GENERATE(0.002, 0.0, -0.001);  // before the jump
  const double before_N = kStiffness_N_per_m * std::max(0.0, depth_m);
  const double after_N = kStiffness_N_per_m * (depth_m + kJump_m);
  const auto at_once_N = forces_round_a_jump_N(0.0, depth_m);
  CHECK(at_once_N[0] == Approx(before_N).margin(1e-4));
  CHECK(at_once_N[1] == Approx(after_N).margin(1e-4));

  const auto spread_N = forces_round_a_jump_N(LocalPlane::kRecovery_s, depth_m);
  CHECK(spread_N[1] == Approx(before_N).margin(1e-4));
  for (std::size_t i = 1; i < 11; ++i)
    CHECK(spread_N[i + 1] - spread_N[i] == Approx(0.1 * (after_N - before_N)).margin(1e-4));
  for (std::size_t i = 11; i < spread_N.size(); ++i)
    CHECK(spread_N[i] == Approx(after_N).margin(1e-4));
}

TEST_CASE("A still flat surface is felt through its plane as by the contact law itself",
          "[local_plane]") {
  publication::StaticScene fixed = rendering::plain_scene(1000.0F, 0.005F);
  fixed.materials[0] = {1000.0F, 4.0F, 0.3F, 0.02F};
  fixed.planes = {{{0.0F, 0.6F, 0.8F}, 0.001F, 0, 0}};
  fixed.tool = {{{0.02F, 0.0F, 0.0F}, 0.005F}, {{-0.02F, 0.0F, 0.003F}, 0.007F}};
  rendering::PublishedScene scene(fixed, {}, 33 * rendering::kMillisecond_ns);
  const auto grid = rendering::make_renderer(display::Transition::kHold);
  LocalModelRenderer plane(std::make_unique<LocalPlane>(0.0));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const auto vector = [&](double size) -> Eigen::Vector3d {
    return size * Eigen::Vector3d(any(random), any(random), any(random));
  };
  int touching = 0;
  for (std::uint64_t ms = 0; ms < 500; ++ms) {
    if (ms % 33 == 0) scene.show({}, ms * rendering::kMillisecond_ns);
    const rendering::ToolPose pose{
        .position_m = vector(0.01),
        .orientation = Eigen::Quaterniond(Eigen::AngleAxisd(any(random), vector(1.0).normalized())),
        .velocity_m_s = vector(0.1),
        .angular_velocity_rad_s = vector(2.0)};
    const rendering::ToolForce by_law =
        grid->render(scene.view(), pose, ms * rendering::kMillisecond_ns).force;
    const rendering::ToolForce by_plane =
        plane.render(scene.view(), pose, ms * rendering::kMillisecond_ns).force;
    CHECK((by_plane.force_N - by_law.force_N).norm() < 1e-5);
    CHECK((by_plane.torque_N_m - by_law.torque_N_m).norm() < 1e-7);
    touching += by_law.contacts > 0 ? 1 : 0;
  }
  CHECK(touching > 100);
}

TEST_CASE("On a sheet of spheres the plane has the slow force where it was made, and its slope",
          "[local_plane]") {
  std::vector<Eigen::Vector3d> centres_m;
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j) centres_m.emplace_back(0.01 * i, 0.01 * j, 0.0);
  rendering::PublishedScene scene(rendering::plain_scene(500.0F, 0.005F),
                                  std::vector<float>(centres_m.size(), 0.01F),
                                  33 * rendering::kMillisecond_ns);
  const auto grid = rendering::make_renderer(display::Transition::kHold);
  for (const double depth_m : {0.0005, 0.002, 0.005}) {
    LocalModelRenderer plane(std::make_unique<LocalPlane>(0.0));
    scene.show(centres_m, 0);
    rendering::ToolPose pose{.position_m = {0.002, 0.003, 0.015 - depth_m}};
    const Eigen::Vector3d law_N = grid->render(scene.view(), pose, 0).force.force_N;
    CHECK((plane.render(scene.view(), pose, 0).force.force_N - law_N).norm() < 1e-9);
    pose.position_m -= 1e-5 * law_N.normalized();  // deeper; the law's own turning is left out
    const double gained_N = (grid->render(scene.view(), pose, 0).force.force_N - law_N).norm();
    CHECK((plane.render(scene.view(), pose, 0).force.force_N - law_N).norm() ==
          Approx(gained_N).epsilon(0.1));
  }
}

}  // namespace
}  // namespace stillgrid::laboratory::local_plane_test
