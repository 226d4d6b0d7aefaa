#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/shared/library/published_ball.hpp"

namespace stillgrid::library::pushes_test {
namespace {

using Catch::Matchers::WithinAbs;
using Eigen::Vector3d;

Vector3d unit(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

TEST_CASE("A free ball's push is that at the end of the step, whatever it weighs", "[pushes]") {
  std::mt19937 random(GENERATE(range(1U, 9U)));
  std::uniform_real_distribution<double> exponent(-3.0, 1.0), share(0.1, 0.9);
  const double mass_kg = std::pow(10.0, exponent(random)), stiffness = 700.0 * share(random);
  const double period_s = 0.037 * share(random), radius_m = 0.02 + 0.01 * share(random);
  const Vector3d towards = unit(random), ball_m = 0.1 * unit(random);
  const double depth_m = 1e-4 * share(random);
  Published scene("free", {.stiffness_N_per_m = stiffness, .period_s = period_s});
  scene.declare({radius_m}, {7});
  scene.hold(ball_m + (radius_m + 0.005 - depth_m) * towards);
  scene.place({ball_m}, {Vector3d::Zero()});
  const double pressed_N = stiffness * depth_m;

  SECTION("with its response") {
    const stillgrid_response response = ball_response(7, ball_m, mass_kg, radius_m);
    REQUIRE(stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_OK);
    const auto pushes = scene.pushes(period_s);
    REQUIRE(pushes.size() == 1);
    CHECK(pushes[0].body == 7);
    CHECK(pushes[0].contacts == 1);
    const double expected_N = pressed_N / (1.0 + stiffness * period_s * period_s / mass_kg);
    // Published places are floats, and a light ball has gone almost all the way.
    const double rounding_N = stiffness * 4e-8;
    CHECK((Vector3d(pushes[0].force_N) + expected_N * towards).norm() <
          1e-3 * expected_N + rounding_N);
    CHECK((Vector3d(pushes[0].point_m) - ball_m).norm() < radius_m + 1e-6);
    CHECK(Vector3d(pushes[0].torque_N_m).norm() < 1e-6 * expected_N);
  }
  SECTION("without, that at its beginning") {
    const auto pushes = scene.pushes(period_s);
    REQUIRE(pushes.size() == 1);
    CHECK((Vector3d(pushes[0].force_N) + pressed_N * towards).norm() <
          1e-3 * pressed_N + stiffness * 4e-8);
  }
}

TEST_CASE("A body on a hinge gives way about it alone", "[pushes]") {
  // A lever of 60 mm about z, whose sphere is pushed across.
  constexpr double kStiffness = 400.0, kPeriod_s = 0.02, kInertia_kg_m2 = 2e-4, kArm_m = 0.06;
  constexpr double kDepth_m = 2e-4;
  const Vector3d end_m(kArm_m, 0.0, 0.0);
  const bool across = GENERATE(true, false);
  const Vector3d towards = across ? Vector3d::UnitY() : Vector3d::UnitZ();
  Published scene("hinge", {.stiffness_N_per_m = kStiffness, .period_s = kPeriod_s});
  scene.declare({0.01}, {3});
  scene.hold(end_m + (0.015 - kDepth_m) * towards);
  scene.place({end_m}, {Vector3d::Zero()});
  stillgrid_response response{};
  response.body = 3;
  response.inverse_inertia[35] = 1.0 / kInertia_kg_m2;
  REQUIRE(stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_OK);
  const auto pushes = scene.pushes(kPeriod_s);
  REQUIRE(pushes.size() == 1);
  const double by = kStiffness * kPeriod_s * kPeriod_s * kArm_m * kArm_m / kInertia_kg_m2;
  const double expected_N = kStiffness * kDepth_m / (across ? 1.0 + by : 1.0);
  CHECK_THAT(Vector3d(pushes[0].force_N).norm(), WithinAbs(expected_N, 2e-3 * expected_N));
}

TEST_CASE("Force, point and torque of a push are those of its contacts together", "[pushes]") {
  constexpr double kStiffness = 300.0;
  std::mt19937 random(GENERATE(range(1U, 9U)));
  Published scene("rod", {.stiffness_N_per_m = kStiffness, .tool_radius_m = 0.02});
  // Two spheres of one body and one of another, all of them in the tool.
  std::vector<Vector3d> places_m;
  for (int i = 0; i < 3; ++i) places_m.push_back(Vector3d(0.3, -0.1, 0.2) + 0.024 * unit(random));
  scene.declare({0.006, 0.005, 0.006}, {1, 1, 4});
  scene.hold({0.3, -0.1, 0.2});
  scene.place(places_m, std::vector<Vector3d>(3, Vector3d::Zero()));
  const auto pushes = scene.pushes(0.01);
  REQUIRE(pushes.size() == 2);
  const stillgrid_push& push = pushes[0].body == 1 ? pushes[0] : pushes[1];
  CHECK(push.contacts == 2);
  Vector3d force_N = Vector3d::Zero(), moment_N_m = force_N;
  const double radii_m[] = {0.006, 0.005};
  for (std::size_t i = 0; i < 2; ++i) {
    const Vector3d away = places_m[i] - Vector3d(0.3, -0.1, 0.2);
    const double depth_m = 0.02 + radii_m[i] - away.norm();
    const Vector3d one_N = kStiffness * depth_m * away.normalized();
    const Vector3d point_m =
        Vector3d(0.3, -0.1, 0.2) + 0.02 / (0.02 + radii_m[i]) * away.norm() * away.normalized();
    force_N += one_N;
    moment_N_m += point_m.cross(one_N);
  }
  CHECK((Vector3d(push.force_N) - force_N).norm() < 1e-3 * force_N.norm());
  const Vector3d told_torque_N_m =
      Vector3d(push.torque_N_m) + Vector3d(push.point_m).cross(Vector3d(push.force_N));
  CHECK((told_torque_N_m - moment_N_m).norm() < 1e-3 * moment_N_m.norm());
}

TEST_CASE("A body goes where its push leads, until something else has resisted it", "[pushes]") {
  constexpr double kPeriod_s = 0.02, kMass_kg = 0.3, kRadius_m = 0.02;
  Published scene("resisted", {.period_s = kPeriod_s});
  const Vector3d ball_m(0.0, 0.0, -0.03);
  const stillgrid_response response = ball_response(2, ball_m, kMass_kg, kRadius_m);
  scene.declare({kRadius_m}, {2});
  scene.hold({0.0, 0.0, -0.006});
  double pushed_N = 0.0, resisted_N = 0.0;
  for (int step = 0; step < 3; ++step) {
    scene.place({ball_m}, {Vector3d::Zero()});
    REQUIRE(stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_OK);
    pushed_N = scene.pushes(kPeriod_s)[0].force_N[2];
    REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
    const auto snapshot = scene.snapshot();
    const double led_m_s = double{snapshot.spheres[0].predicted_velocity_m_s[2]};
    // The ball has not moved: what held it against the last push holds it on against as much.
    const double expected_m_s = kPeriod_s * (pushed_N - resisted_N) / kMass_kg;
    resisted_N = pushed_N;
    CHECK_THAT(led_m_s, WithinAbs(expected_m_s, 1e-5));
    CHECK(snapshot.header.mode_count > 0);
    CHECK(snapshot.spheres[0].response == 1);
  }
  CHECK(pushed_N < -0.1);
}

TEST_CASE("A body that something holds is pushed by the law, however it would give way",
          "[pushes]") {
  constexpr double kStiffness = 500.0, kPeriod_s = 0.033, kMass_kg = 0.1, kRadius_m = 0.02;
  constexpr double kDepth_m = 1e-3;
  const bool is_tried = GENERATE(true, false);
  Published scene("held", {.stiffness_N_per_m = kStiffness, .period_s = kPeriod_s});
  const Vector3d ball_m(0.0, 0.0, -0.03), still_m_s = Vector3d::Zero();
  const stillgrid_response response = ball_response(2, ball_m, kMass_kg, kRadius_m);
  scene.declare({kRadius_m}, {2});
  scene.hold({0.0, 0.0, -0.03 + kRadius_m + 0.005 - kDepth_m});
  double before_N = 0.0;
  for (int step = 0; step < 60; ++step) {
    scene.place({ball_m}, {Vector3d::Zero()});
    REQUIRE(stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_OK);
    if (is_tried)
      REQUIRE(stillgrid_publisher_set_predicted(scene, 1, still_m_s.data()) == STILLGRID_OK);
    const double pushed_N = -scene.pushes(kPeriod_s)[0].force_N[2];
    CHECK(pushed_N > before_N - 1e-3);  // never beyond, never back
    before_N = pushed_N;
  }
  CHECK_THAT(before_N, WithinAbs(kStiffness * kDepth_m, 0.01 * kStiffness * kDepth_m));
}

TEST_CASE("What an engine predicts is published as it is", "[pushes]") {
  Published scene("predicted", {});
  const Vector3d ball_m(0.1, 0.0, 0.0), led_m_s(0.03, -0.02, 0.5);
  scene.declare({0.01}, {0});
  scene.place({ball_m}, {Vector3d(1.0, 0.0, 0.0)});
  REQUIRE(stillgrid_publisher_set_predicted(scene, 1, led_m_s.data()) == STILLGRID_OK);
  REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
  const auto snapshot = scene.snapshot();
  for (std::size_t axis = 0; axis < 3; ++axis)
    CHECK(snapshot.spheres[0].predicted_velocity_m_s[axis] ==
          static_cast<float>(led_m_s[static_cast<Eigen::Index>(axis)]));
  CHECK(snapshot.header.prediction_ns == 10'000'000);
}

TEST_CASE("A push knows where the engine's step leads without it", "[pushes]") {
  // A bead on a stiff spring, which goes half way back by itself: W is that of the implicit step.
  std::mt19937 random(GENERATE(range(1U, 9U)));
  std::uniform_real_distribution<double> share(0.2, 1.0);
  const double period_s = 0.02, stiffness = 600.0 * share(random), mass_kg = 0.05 * share(random);
  const double held_N_per_m = 800.0 * share(random), stretched_m = 1e-3 * share(random);
  Published scene("spring", {.stiffness_N_per_m = stiffness, .period_s = period_s});
  const Vector3d bead_m(0.0, 0.0, -stretched_m);
  const double radius_m = 0.02, resists = mass_kg + period_s * period_s * held_N_per_m;
  stillgrid_response response{};
  for (std::size_t i = 0; i < 3; ++i) response.inverse_inertia[7 * i] = 1.0 / resists;
  Eigen::Map<Vector3d>(response.centre_m) = bead_m;
  scene.declare({radius_m}, {0});
  const double tool_m = radius_m + 0.005 - 5e-4;
  scene.hold({0.0, 0.0, tool_m});
  scene.place({bead_m}, {Vector3d::Zero()});
  const double free_m = period_s * period_s * held_N_per_m * stretched_m / resists;
  const double free_m_s[] = {0.0, 0.0, free_m / period_s};
  REQUIRE(stillgrid_publisher_set_trial(scene, 1, free_m_s) == STILLGRID_OK);
  REQUIRE(stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_OK);
  const auto pushes = scene.pushes(period_s);
  const double depth_m = radius_m + 0.005 - (tool_m - (bead_m.z() + free_m));
  const double expected_N =
      depth_m > 0.0 ? stiffness * depth_m / (1.0 + stiffness * period_s * period_s / resists) : 0.0;
  const double pushed_N = pushes.empty() ? 0.0 : -pushes[0].force_N[2];
  CHECK_THAT(pushed_N, WithinAbs(expected_N, 2e-3 * expected_N + stiffness * 1e-8));
  REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
  const double led_m_s = double{scene.snapshot().spheres[0].predicted_velocity_m_s[2]};
  CHECK_THAT(led_m_s, WithinAbs(free_m_s[2] - period_s * pushed_N / resists, 1e-5));
}

TEST_CASE("A light ball that flies deep into the tool is pushed as it gives way", "[pushes]") {
  // 26 mm in a step, from below; a gram and 2000 N/m.
  constexpr double kStiffness = 2000.0, kPeriod_s = 0.02, kRadius_m = 0.02;
  const double mass_kg = GENERATE(0.002, 0.05, 2.0);
  const double gap_m = GENERATE(0.002, 0.007, 0.015);
  Published scene("deep", {.stiffness_N_per_m = kStiffness, .period_s = kPeriod_s});
  const Vector3d ball_m(0.0, 0.0, 0.0);
  scene.declare({kRadius_m}, {0});
  scene.hold({0.0, 0.0, -(kRadius_m + 0.005 + gap_m)});
  const Vector3d velocity_m_s(0.0, 0.0, -1.3);
  scene.place({ball_m}, {velocity_m_s});
  const stillgrid_response response = ball_response(0, ball_m, mass_kg, kRadius_m);
  REQUIRE(stillgrid_publisher_set_trial(scene, 1, velocity_m_s.data()) == STILLGRID_OK);
  REQUIRE(stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_OK);
  const auto pushes = scene.pushes(kPeriod_s);
  const double depth_m = 1.3 * kPeriod_s - gap_m;
  const double expected_N =
      kStiffness * depth_m / (1.0 + kStiffness * kPeriod_s * kPeriod_s / mass_kg);
  REQUIRE(pushes.size() == 1);
  CHECK_THAT(pushes[0].force_N[2], WithinAbs(expected_N, 0.02 * expected_N));
}

TEST_CASE("The tool's work is its pushes' along the ways that the spheres went", "[pushes]") {
  Published scene("work", {});
  scene.declare({0.02}, {1});
  scene.hold({0.0, 0.0, 0.0245});
  scene.place({Vector3d::Zero()}, {Vector3d::Zero()});
  const double pushed_N = scene.pushes(0.01)[0].force_N[2];
  scene.place({Vector3d(0.0, 0.0, -1e-3)}, {Vector3d::Zero()});
  REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
  CHECK_THAT(scene.snapshot().header.tool_work_J, WithinAbs(-1e-3 * pushed_N, 1e-9));
  CHECK(scene.snapshot().header.tool_time_ns > 0);
}

}  // namespace
}  // namespace stillgrid::library::pushes_test
