#include "tests/laboratory/rivals/force_jacobian.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/laboratory/rivals/rivals.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::laboratory::force_jacobian_test {
namespace {

constexpr int kPeriod_ticks = 33;
constexpr std::uint64_t kPeriod_ns = kPeriod_ticks * rendering::kMillisecond_ns;

/// A probe that goes in and out of a body, and along it, at one hertz.
rendering::ToolPose stroking_probe(double time_s) {
  const double angle = 6.283185307179586 * time_s;
  return {.position_m = {0.002 * std::sin(0.5 * angle), 0.0, 0.104 + 0.004 * std::sin(angle)}};
}

struct RmsErrors {
  double held_N, over_time_N, over_position_N;
};

/// rms distance from the true force, over four seconds, of a force held, extrapolated over time
/// from the last two, and extrapolated over the device's position; the body, a sphere of 100 mm,
/// rises at speed_m_s. Snapshots are made of the tool as it is at their switch.
RmsErrors extrapolation_errors(double speed_m_s) {
  rendering::PublishedScene scene(rendering::plain_scene(500.0F, 0.01F), {0.1F}, kPeriod_ns);
  rendering::PublishedScene truth(rendering::plain_scene(500.0F, 0.01F), {0.1F},
                                  rendering::kMillisecond_ns);
  const auto true_force = rendering::make_renderer(display::Transition::kHold);
  const auto held = rival_named("force_held")->make();
  const auto linear = rival_named("force_jacobian")->make();
  Eigen::Vector3d newest_N = Eigen::Vector3d::Zero(), before_N = newest_N, squares = newest_N;
  for (int i = 0; i < 4000; ++i) {
    const double time_s = 1e-3 * i;
    const auto now_ns = static_cast<std::uint64_t>(i) * rendering::kMillisecond_ns;
    const rendering::ToolPose probe = stroking_probe(time_s);
    const std::vector<Eigen::Vector3d> body_m{{0.0, 0.0, speed_m_s * (time_s - 2.0)}};
    truth.show(body_m, now_ns);
    if (i % kPeriod_ticks == 0) scene.show(body_m, now_ns);
    const auto force_N = [&](const auto& model,
                             const rendering::PublishedScene& shown) -> Eigen::Vector3d {
      return model->render(shown.view(), probe, now_ns).force.force_N;
    };
    const Eigen::Vector3d true_N = force_N(true_force, truth), held_N = force_N(held, scene);
    if (i % kPeriod_ticks == 0) before_N = std::exchange(newest_N, held_N);
    const Eigen::Vector3d over_time_N =
        newest_N + (newest_N - before_N) * (i % kPeriod_ticks) / kPeriod_ticks;
    if (i >= 2 * kPeriod_ticks)
      squares +=
          Eigen::Vector3d((held_N - true_N).squaredNorm(), (over_time_N - true_N).squaredNorm(),
                          (force_N(linear, scene) - true_N).squaredNorm());
    else
      static_cast<void>(force_N(linear, scene));
  }
  const Eigen::Vector3d rms = (squares / (4000.0 - 2 * kPeriod_ticks)).cwiseSqrt();
  return {rms[0], rms[1], rms[2]};
}

TEST_CASE("Force over position is nearer the truth than over time, and held is worst",
          "[force_jacobian]") {
  // Picinbono: against a body that stands or moves slowly beside the probe.
  const double speed_m_s = GENERATE(0.0, 0.0005, 0.001);
  const RmsErrors rms = extrapolation_errors(speed_m_s);
  CAPTURE(speed_m_s, rms.held_N, rms.over_time_N, rms.over_position_N);
  CHECK(rms.over_position_N < 0.5 * rms.over_time_N);
  CHECK(rms.over_time_N < rms.held_N);
}

TEST_CASE("Where the body moves about as fast as the probe, force over time is the better",
          "[force_jacobian]") {
  const RmsErrors rms = extrapolation_errors(0.01);
  CHECK(rms.over_time_N < rms.over_position_N);
}

TEST_CASE("Force and torque by a turn, a way and a speed are the derivatives of the contact law",
          "[force_jacobian]") {
  publication::StaticScene fixed = rendering::plain_scene(800.0F, 0.006F);
  fixed.materials[0] = {800.0F, 3.0F, 0.4F, 0.05F};
  fixed.planes = {{{0.0F, 0.0F, 1.0F}, 0.0F, 0, 0}};
  fixed.tool = {{{0.02F, 0.0F, 0.0F}, 0.006F}, {{-0.01F, 0.005F, 0.0F}, 0.006F}};
  rendering::PublishedScene scene(fixed, {0.01F}, kPeriod_ns);
  scene.show({{0.028, 0.004, 0.004}}, {{0.01, 0.0, 0.02}}, 0);
  const auto grid = rendering::make_renderer(display::Transition::kHold);
  const auto linear = rival_named("force_jacobian")->make();
  const rendering::ToolPose start{
      .position_m = {0.0, 0.0, 0.003},
      .orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.6, 0.0, 0.8))),
      .velocity_m_s = {0.01, 0.02, -0.03},
      .angular_velocity_rad_s = {0.5, -0.2, 0.3}};
  static_cast<void>(linear->render(scene.view(), start, 0));
  const auto error = [&](double size) {
    rendering::ToolPose moved = start;
    moved.position_m += size * Eigen::Vector3d(1e-3, -2e-3, 1e-3);
    moved.orientation =
        Eigen::AngleAxisd(0.05 * size, Eigen::Vector3d(0.0, 0.8, 0.6)) * start.orientation;
    moved.velocity_m_s += size * Eigen::Vector3d(0.002, 0.001, -0.002);
    moved.angular_velocity_rad_s += size * Eigen::Vector3d(0.1, 0.1, 0.0);
    const rendering::ToolForce by_law = grid->render(scene.view(), moved, 0).force;
    const rendering::ToolForce by_model = linear->render(scene.view(), moved, 0).force;
    REQUIRE(by_law.contacts > 1);
    CHECK(by_model.contacts == by_law.contacts);
    return Eigen::Vector2d((by_model.force_N - by_law.force_N).norm(),
                           (by_model.torque_N_m - by_law.torque_N_m).norm());
  };
  const Eigen::Vector2d whole = error(0.2), half = error(0.1);
  CHECK(error(0.0).norm() < 1e-6);
  CHECK(whole[0] / half[0] == Approx(4.0).epsilon(0.15));
  CHECK(whole[1] / half[1] == Approx(4.0).epsilon(0.15));
}

TEST_CASE("A tool that leaves is held back by a force over position until the next snapshot",
          "[force_jacobian]") {
  publication::StaticScene fixed = rendering::plain_scene(1000.0F, 0.005F);
  fixed.planes = {{{0.0F, 0.0F, 1.0F}, 0.0F, 0, 0}};
  rendering::PublishedScene scene(fixed, {}, kPeriod_ns);
  scene.show({}, 0);
  const auto linear = rival_named("force_jacobian")->make();
  const auto lift_N = [&](double height_m) {
    return linear->render(scene.view(), {.position_m = {0.0, 0.0, height_m}}, 0).force.force_N.z();
  };
  CHECK(lift_N(0.004) == Approx(1.0).epsilon(1e-4));
  CHECK(lift_N(0.007) == Approx(-2.0).epsilon(1e-4));
  scene.show({}, kPeriod_ns);
  CHECK(lift_N(0.007) == 0.0);
}

}  // namespace
}  // namespace stillgrid::laboratory::force_jacobian_test
