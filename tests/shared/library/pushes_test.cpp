#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "shared/local/given_bodies.hpp"
#include "tests/shared/library/published_ball.hpp"

namespace stillgrid::library::pushes_test {
namespace {

using Catch::Matchers::WithinAbs;
using Eigen::Vector3d;
constexpr double kRadius_m = 0.02, kTouching_m = kRadius_m + 0.005, kTick_s = 1e-3;

/// A ball along z, below a tool.
struct Ball {
  double mass_kg, z_m = 0.0, velocity_m_s = 0.0;

  /// An engine's step under a force that is held, in small steps.
  void step(double step_s, double force_N, double acceleration_m_s2 = 0.0) {
    for (int i = 0; i < 100; ++i) {
      velocity_m_s += 0.01 * step_s * (force_N / mass_kg + acceleration_m_s2);
      z_m += 0.01 * step_s * velocity_m_s;
    }
  }
  void place(Published& scene) const {
    scene.place({Vector3d(0.0, 0.0, z_m)}, {Vector3d(0.0, 0.0, velocity_m_s)});
    stillgrid_response response = ball_response(0, Vector3d(0.0, 0.0, z_m), mass_kg, kRadius_m);
    response.velocity[2] = velocity_m_s;
    scene.respond(response);
  }
};

/// The mean force of the tool on the ball in a 1 kHz simulation from that state on.
double simulated_N(Ball ball, double stiffness, const Published::Path& tool, double from_s,
                   int ticks, double acceleration_m_s2 = 0.0) {
  double impulse = 0.0;
  for (int tick = 1; tick <= ticks; ++tick) {
    ball.velocity_m_s += kTick_s * acceleration_m_s2;
    const double led_m = ball.z_m + kTick_s * ball.velocity_m_s;
    const double depth_m = led_m + kTouching_m - tool(from_s + kTick_s * tick).first.z();
    const double force_N =
        stiffness * std::max(0.0, depth_m) / (1.0 + stiffness * kTick_s * kTick_s / ball.mass_kg);
    ball.velocity_m_s -= kTick_s * force_N / ball.mass_kg;
    ball.z_m += kTick_s * ball.velocity_m_s;
    impulse += kTick_s * force_N;
  }
  return -impulse / (kTick_s * ticks);
}

/// Down by depth_m in duration_s from a height at start_s, and there it stays.
Published::Path tap(double height_m, double depth_m, double start_s, double duration_s) {
  return [=](double time_s) {
    const double share = std::clamp((time_s - start_s) / duration_s, 0.0, 1.0);
    const double speed_m_s = share > 0.0 && share < 1.0 ? -depth_m / duration_s : 0.0;
    return std::pair(Vector3d(0.0, 0.0, height_m - depth_m * share), Vector3d(0.0, 0.0, speed_m_s));
  };
}
double z_of(const std::vector<stillgrid_push>& pushes) {
  return pushes.empty() ? 0.0 : pushes[0].force_N[2];
}

TEST_CASE("Each push of a fast tap is that of the 1 kHz simulation of the same ball", "[pushes]") {
  // Found wrong when contact was looked for at the beginning of a step alone: f, 0, f, 0.
  std::mt19937 random(GENERATE(range(0U, 9U)));
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const bool is_first = GENERATE(0, 1) == 0;
  const double mass_kg = is_first ? 0.1 : 0.02 * std::pow(50.0, share(random));
  const double stiffness = is_first ? 620.0 : 200.0 + 600.0 * share(random);
  const double period_s = is_first ? 0.04 : 0.01 + 0.001 * std::floor(40.0 * share(random));
  const Published::Path tool = tap(kTouching_m + 0.001, 0.008, 0.1 * share(random), 0.02);
  Published scene(
      "tap",
      {.stiffness_N_per_m = stiffness, .period_s = period_s, .clock = STILLGRID_VIRTUAL_TIME});
  scene.declare({kRadius_m}, {0});
  scene.move(tool);
  Ball ball{mass_kg};
  ball.place(scene);
  double before_s = scene.wait();
  scene.publish();
  double impulse = 0.0;
  for (int step = 0; step < 10; ++step) {
    const double time_s = scene.wait();
    const double pushed_N = z_of(scene.pushes(period_s));
    const int ticks = static_cast<int>(std::lround((time_s - before_s) / kTick_s));
    const double expected_N = simulated_N(ball, stiffness, tool, before_s, ticks);
    CHECK_THAT(pushed_N, WithinAbs(expected_N, 0.02 * std::abs(expected_N) + 1e-5));
    ball.step(period_s, pushed_N);
    impulse += period_s * pushed_N;
    ball.place(scene);
    scene.publish();
    before_s = time_s;
  }
  CHECK(impulse < 0.0);
  CHECK_THAT(mass_kg * ball.velocity_m_s, WithinAbs(impulse, 1e-9));
}

TEST_CASE("A ball that a tap presses onto a floor is pushed in every step to the end", "[pushes]") {
  // 8 mm in 20 ms at 25 Hz onto a ball on a floor of 3 kN/m.
  const double mass_kg = GENERATE(0.02, 0.05, 0.1, 0.5);
  constexpr double kStiffness = 620.0, kFloor_N_per_m = 3000.0;
  const double damping_N_s_per_m = GENERATE(0.6, 2.0) * std::sqrt(kFloor_N_per_m * mass_kg);
  const double period_s = GENERATE(0.01, 0.02, 0.033, 0.04);
  Published scene(
      "floor",
      {.stiffness_N_per_m = kStiffness, .period_s = period_s, .clock = STILLGRID_VIRTUAL_TIME});
  scene.declare({kRadius_m}, {0});
  scene.move(tap(kTouching_m + 0.001, 0.008, 0.05, 0.02));
  Ball ball{mass_kg};
  ball.place(scene);
  (void)scene.wait();
  scene.publish();
  std::vector<double> pushed_N;
  for (double time_s = 0.0; time_s < 3.0;) {
    time_s = scene.wait();
    pushed_N.push_back(-z_of(scene.pushes(period_s)));
    for (int i = 0; i < 400; ++i) {
      const double held_N = ball.z_m < 0.0 ? -kFloor_N_per_m * ball.z_m : 0.0;
      ball.velocity_m_s += period_s / 400 *
                           (-pushed_N.back() + held_N - damping_N_s_per_m * ball.velocity_m_s) /
                           mass_kg;
      ball.z_m += period_s / 400 * ball.velocity_m_s;
    }
    ball.place(scene);
    scene.publish();
  }
  // At rest both springs carry the same.
  const double rest_N = 0.007 / (1.0 / kStiffness + 1.0 / kFloor_N_per_m);
  std::string all;
  for (const double x : pushed_N) all += std::to_string(x) + " ";
  INFO(all);
  int wrong = 0;
  for (std::size_t i = pushed_N.size() / 2; i < pushed_N.size(); ++i)
    wrong += std::abs(pushed_N[i] - rest_N) > 0.02 * rest_N;
  CHECK(wrong == 0);
}

TEST_CASE("Force, point and torque of a push are those of its contacts together", "[pushes]") {
  // A ball between three others, two of one body and one of another, each 45 degrees off its way.
  constexpr double kStiffness = 300.0, kTool_m = 0.02, kBall_m = 0.005, kDepth_m = 0.004;
  const Vector3d seat_m(0.3, -0.1, 0.2);
  Published scene("rod", {.stiffness_N_per_m = kStiffness,
                          .period_s = 0.01,
                          .tool_radius_m = kTool_m,
                          .gives_inertia = 0,
                          .clock = STILLGRID_VIRTUAL_TIME});
  std::vector<Vector3d> normals, places_m;
  for (int i = 0; i < 3; ++i) {
    const double turn_rad = 2.0 * std::numbers::pi * i / 3.0;
    normals.push_back(std::sqrt(0.5) * Vector3d(std::cos(turn_rad), std::sin(turn_rad), 1.0));
    places_m.push_back(seat_m - (kTool_m + kBall_m) * normals.back());
  }
  scene.declare(std::vector<double>(3, kBall_m), {1, 1, 4});
  scene.move([&](double time_s) {
    const double down_m = kDepth_m * std::clamp(time_s / 0.02, 0.0, 1.0);
    return std::pair(Vector3d(seat_m - down_m * Vector3d::UnitZ()), Vector3d(Vector3d::Zero()));
  });
  std::vector<stillgrid_push> pushes;
  for (int step = 0; step < 6; ++step) {
    scene.place(places_m, std::vector<Vector3d>(3, Vector3d::Zero()));
    scene.wait();
    if (step > 0) pushes = scene.pushes(0.01);
    if (step > 0) scene.place(places_m, std::vector<Vector3d>(3, Vector3d::Zero()));
    scene.publish();
  }
  REQUIRE(pushes.size() == 2);
  const stillgrid_push& push = pushes[0].body == 1 ? pushes[0] : pushes[1];
  CHECK(push.contacts == 2);
  // Each bears a third of the weight along z.
  const Vector3d tool_m = seat_m - kDepth_m * Vector3d::UnitZ();
  Vector3d force_N = Vector3d::Zero(), moment_N_m = force_N;
  for (std::size_t i = 0; i < 2; ++i) {
    const Vector3d one_N = -kStiffness * kDepth_m / (3.0 * std::sqrt(0.5)) * normals[i];
    force_N += one_N;
    moment_N_m += (tool_m - kTool_m * normals[i]).cross(one_N);
  }
  CHECK((Vector3d(push.force_N) - force_N).norm() < 1e-3 * force_N.norm());
  const Vector3d told_torque_N_m =
      Vector3d(push.torque_N_m) + Vector3d(push.point_m).cross(Vector3d(push.force_N));
  CHECK((told_torque_N_m - moment_N_m).norm() < 1e-3 * moment_N_m.norm());
}

TEST_CASE("Two hands hold a ball, and a snapshot carries it for both", "[pushes]") {
  constexpr double kStiffness = 500.0, kDepth_m = 1e-3, kPeriod_s = 0.033;
  Published scene("two", {.stiffness_N_per_m = kStiffness,
                          .period_s = kPeriod_s,
                          .clock = STILLGRID_VIRTUAL_TIME,
                          .hands = 2});
  scene.declare({kRadius_m}, {0});
  for (const std::size_t hand : {0U, 1U})
    scene.move(
        [=](double time_s) {
          const double apart_m = kTouching_m - kDepth_m * std::clamp(time_s / 0.02, 0.0, 1.0);
          const double side = hand == 0 ? 1.0 : -1.0;
          return std::pair(Vector3d(0.0, 0.0, side * apart_m), Vector3d(Vector3d::Zero()));
        },
        hand);
  const Ball ball{0.1};
  ball.place(scene);
  scene.wait();
  scene.publish();
  for (int step = 0; step < 5; ++step) {
    scene.wait();
    const auto pushes = scene.pushes(kPeriod_s);
    REQUIRE(pushes.size() == 2);
    for (const double side : {-1.0, 1.0})
      if (step > 0)
        CHECK_THAT(pushes[side < 0.0 ? 0 : 1].force_N[2],
                   WithinAbs(side * kStiffness * kDepth_m, 1e-5));
    ball.place(scene);
    scene.publish();
  }
  const auto snapshot = scene.snapshot();
  CHECK(snapshot.header.state_tick == 165);
  REQUIRE(local::is_given_model(snapshot.model));
  const local::GivenModel model = local::decode_given_model(snapshot.model);
  CHECK(model.period_ticks == 33);
  REQUIRE(model.tools.size() == 2);
  CHECK(snapshot.hands == 2);  // else haptic_server refuses the model
  local::GivenState state;
  REQUIRE(decode(snapshot.state, model, state));
  REQUIRE(state.bodies.size() == 1);
  CHECK(state.spheres.size() == 1);
  CHECK(state.bodies[0].twist.norm() == 0.0);
  CHECK(state.bodies[0].acceleration.norm() < 1e-3);
  CHECK_THAT(state.bodies[0].inverse_inertia(0, 0), WithinAbs(10.0, 1e-12));
}

TEST_CASE("A step of the engine takes its own part of the path, and all together the whole",
          "[pushes]") {
  // Four steps a period; the tool is pushed into a sphere that gives no way.
  constexpr double kStiffness = 500.0, kPeriod_s = 0.02;
  const Published::Path tool = tap(kTouching_m, 0.004, 0.02, 0.02);
  Published scene("parts", {.stiffness_N_per_m = kStiffness,
                            .period_s = kPeriod_s,
                            .gives_inertia = 0,
                            .clock = STILLGRID_VIRTUAL_TIME});
  scene.declare({kRadius_m}, {0});
  scene.move(tool);
  const auto place = [&] { scene.place({Vector3d::Zero()}, {Vector3d::Zero()}); };
  place();
  scene.wait();
  scene.publish();
  scene.wait();
  scene.publish();
  scene.wait();
  for (int part = 0; part < 4; ++part) {
    double expected_N = 0.0;
    for (int tick = 1; tick <= 5; ++tick) expected_N -= 0.2 * kStiffness * 2e-4 * (5 * part + tick);
    CHECK_THAT(z_of(scene.pushes(kPeriod_s / 4)), WithinAbs(expected_N, 1e-5));
    place();
  }
  scene.publish();
}

TEST_CASE("The tool's work is its forces along the ways of the bodies, tick by tick", "[pushes]") {
  const Published::Path tool = tap(kTouching_m, 0.004, 0.0, 0.02);
  Published scene("work", {.period_s = 0.04, .clock = STILLGRID_VIRTUAL_TIME});
  scene.declare({kRadius_m}, {0});
  scene.move(tool);
  Ball ball{0.05};
  ball.place(scene);
  scene.wait();
  scene.publish();
  scene.wait();
  ball.velocity_m_s += 0.04 * z_of(scene.pushes(0.04)) / ball.mass_kg;
  ball.place(scene);
  scene.publish();
  // It was at rest and free: the work is its energy, but for what implicit Euler takes.
  const double energy_J = 0.5 * ball.mass_kg * ball.velocity_m_s * ball.velocity_m_s;
  CHECK_THAT(scene.snapshot().header.tool_work_J, WithinAbs(energy_J, 0.06 * energy_J));
  CHECK(scene.snapshot().header.tool_time_ns == 40'000'000);
}

}  // namespace
}  // namespace stillgrid::library::pushes_test
