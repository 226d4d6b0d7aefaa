#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/shared/local/given_scene.hpp"

namespace stillgrid::local::given_bodies_test {
namespace {

using Catch::Matchers::WithinAbs;
using Eigen::Vector3d;
constexpr double kTick_s = 1e-3, kRadius_m = 0.02, kTouching_m = kRadius_m + 0.005;

TEST_CASE("A tool that runs into a free ball sends it off at twice its speed", "[given_bodies]") {
  std::mt19937 random(GENERATE(range(1U, 13U)));
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const double mass_kg = 0.02 * std::pow(100.0, share(random));
  const double rate_per_s = 10.0 + 110.0 * share(random), speed_m_s = 0.05 + 0.3 * share(random);
  GivenBodies bodies(ball_model(mass_kg * rate_per_s * rate_per_s));
  bodies.begin(one_ball(mass_kg, kRadius_m));
  const Vector3d way = Vector3d(share(random), share(random), 0.1 + share(random)).normalized();
  double work_J = 0.0;
  const int ticks = static_cast<int>(std::numbers::pi / rate_per_s / kTick_s) + 20;
  for (int tick = 1; tick <= ticks; ++tick) {
    const double gone_m = tick * kTick_s * speed_m_s;
    const Tools tools{tool_at((gone_m - kTouching_m) * way, speed_m_s * way)};
    bodies.step(tools);
    // While they touch: depth d, d'' = -d k / m.
    const double exact_m = gone_m - speed_m_s / rate_per_s * std::sin(rate_per_s * tick * kTick_s);
    if (tick * kTick_s * rate_per_s < std::numbers::pi)
      REQUIRE((bodies.bodies()[0].centre_m - exact_m * way).norm() <
              2.0 * kTick_s * speed_m_s * (1.0 + rate_per_s * kTick_s * tick));
  }
  const Twist& twist = bodies.bodies()[0].twist;
  // Implicit Euler takes a share of the rebound, of the order of the tick.
  const double lost = 0.25 * std::numbers::pi * rate_per_s * kTick_s;
  CHECK((twist.head<3>() - 2.0 * speed_m_s * way).norm() < (1.2 * lost + 0.005) * 2.0 * speed_m_s);
  CHECK(twist.tail<3>().norm() < 1e-9);
  const GivenBodies::Push& push = bodies.push(0, 0);
  CHECK((push.wrench.head<3>() - mass_kg * twist.head<3>()).norm() < 1e-9 * mass_kg * speed_m_s);
  CHECK(push.contacts == 1);
  work_J = 0.5 * mass_kg * twist.head<3>().squaredNorm();
  CHECK_THAT(push.work_J, WithinAbs(work_J, 0.03 * work_J + 2.0 * lost * work_J));
}

TEST_CASE("A body moves on by its twist and acceleration", "[given_bodies]") {
  GivenState state = one_ball(0.1, kRadius_m);
  state.bodies[0].twist << 0.1, 0.0, 0.0, 0.0, 0.0, 2.0;
  state.bodies[0].acceleration << 0.0, 0.0, -9.81, 0.0, 0.0, 0.0;
  state.spheres[0].arm_m = Vector3d(0.01, 0.0, 0.0);
  GivenBodies bodies(ball_model(500.0));
  bodies.begin(state);
  for (int tick = 0; tick < 50; ++tick) bodies.step(Tools{std::nullopt});
  const Vector3d centre_m(0.005, 0.0, -0.5 * 9.81 * 0.05 * 0.051);
  CHECK((bodies.bodies()[0].centre_m - centre_m).norm() < 1e-12);
  const GivenSphere& sphere = bodies.spheres()[0];
  const Vector3d arm_m(0.01 * std::cos(0.1), 0.01 * std::sin(0.1), 0.0);
  CHECK((bodies.position_m(sphere) - centre_m - arm_m).norm() < 1e-12);
  CHECK((bodies.velocity_m_s(sphere, centre_m + arm_m) -
         Vector3d(0.1 - 2.0 * arm_m.y(), 2.0 * arm_m.x(), -9.81 * 0.05))
            .norm() < 1e-12);
  bodies.stand();
  CHECK(bodies.velocity_m_s(sphere, centre_m).norm() == 0.0);
}

TEST_CASE("A body on a hinge turns about it alone", "[given_bodies]") {
  // A lever from the origin to a sphere at its end; its centre is half way.
  std::mt19937 random(GENERATE(range(1U, 9U)));
  std::normal_distribution<double> normal;
  const Vector3d axis = Vector3d(normal(random), normal(random), normal(random)).normalized();
  const Vector3d arm = axis.unitOrthogonal(), across = axis.cross(arm);
  constexpr double kArm_m = 0.06, kInertia_kg_m2 = 2e-4, kStiffness = 400.0;
  Twist motion;
  motion << axis.cross(0.5 * kArm_m * arm), axis;
  GivenState state;
  state.bodies = {{.number = 1,
                   .centre_m = 0.5 * kArm_m * arm,
                   .inverse_inertia = motion * motion.transpose() / kInertia_kg_m2}};
  state.spheres = {{.radius_m = 0.01, .arm_m = 0.5 * kArm_m * arm}};
  GivenBodies bodies(ball_model(kStiffness));

  SECTION("pressed across") {
    bodies.begin(state);
    bodies.step(Tools{tool_at(kArm_m * arm - 0.015 * across)});
    const Tools tools{tool_at(kArm_m * arm - 0.0148 * across)};
    bodies.step(tools);
    const Twist twist = bodies.bodies()[0].twist;
    const double expected_rad_s =
        kTick_s * kStiffness * 2e-4 * kArm_m / kInertia_kg_m2 /
        (1.0 + kTick_s * kTick_s * kStiffness * kArm_m * kArm_m / kInertia_kg_m2);
    CHECK((twist - expected_rad_s * motion).norm() < 1e-5 * expected_rad_s);
    for (int tick = 0; tick < 30; ++tick) bodies.step(tools);
    const Vector3d turning_rad_s = bodies.bodies()[0].twist.tail<3>();
    CHECK(turning_rad_s.cross(axis).norm() < 1e-9 * turning_rad_s.norm());
    CHECK(turning_rad_s.dot(axis) > 0.0);
  }
  SECTION("pressed along its axis and towards the hinge") {
    bodies.begin(state);
    const Vector3d towards = GENERATE(0, 1) == 0 ? axis : arm;
    bodies.step(Tools{tool_at(kArm_m * arm + 0.015 * towards)});
    for (int tick = 0; tick < 30; ++tick)
      bodies.step(Tools{tool_at(kArm_m * arm + 0.0145 * towards)});
    CHECK(bodies.bodies()[0].twist.norm() < 1e-9);
    const Twist mean = bodies.push(0, 0).wrench / (30 * kTick_s);
    CHECK((mean.head<3>() + kStiffness * 5e-4 * towards).norm() < 1e-6);
  }
}

TEST_CASE("Two hands hold a ball between them, each by its own push", "[given_bodies]") {
  constexpr double kStiffness = 500.0, kDepth_m = 1e-3;
  const double mass_kg = GENERATE(0.005, 0.1, 3.0);
  GivenBodies bodies(ball_model(kStiffness, 2));
  bodies.begin(one_ball(mass_kg, kRadius_m));
  const Vector3d left_m(kDepth_m - kTouching_m, 0.0, 0.0), right_m = -left_m;
  const Vector3d outside_m(kTouching_m, 0.0, 0.0);
  const Tools outside{tool_at(-outside_m), tool_at(outside_m)};
  bodies.step(outside);
  for (int tick = 0; tick < 100; ++tick) bodies.step(Tools{tool_at(left_m), tool_at(right_m)});
  CHECK(bodies.bodies()[0].centre_m.norm() < 1e-12);
  CHECK_THAT(bodies.push(0, 0).wrench[0], WithinAbs(0.1 * kStiffness * kDepth_m, 1e-9));
  CHECK_THAT(bodies.push(1, 0).wrench[0], WithinAbs(-0.1 * kStiffness * kDepth_m, 1e-9));
  // One lets go by a half: the pushes differ by what moves the ball.
  bodies.begin(one_ball(mass_kg, kRadius_m));
  bodies.step(outside);
  const Vector3d back_m(kTouching_m - 0.5 * kDepth_m, 0.0, 0.0);
  for (int tick = 0; tick < 10; ++tick) bodies.step(Tools{tool_at(left_m), tool_at(back_m)});
  const double momentum = mass_kg * bodies.bodies()[0].twist[0];
  CHECK_THAT(bodies.push(0, 0).wrench[0] + bodies.push(1, 0).wrench[0],
             WithinAbs(momentum, 1e-12 + 1e-9 * std::abs(momentum)));
  CHECK(bodies.push(1, 0).wrench[0] < 0.0);
}

TEST_CASE("No stiffness is too much for a light body", "[given_bodies]") {
  // Explicitly a contact diverges beyond k h^2 = 4 m.
  std::mt19937 random(GENERATE(range(1U, 17U)));
  std::uniform_real_distribution<double> share(0.0, 1.0);
  GivenModel model = ball_model(std::pow(10.0, 2.0 + 3.0 * share(random)));
  model.materials[0].damping_N_s_per_m = 20.0 * share(random);
  model.materials[0].friction = share(random);
  const double mass_kg = std::pow(10.0, -5.0 * share(random));
  GivenBodies bodies(model);
  bodies.begin(one_ball(mass_kg, kRadius_m));
  const Vector3d velocity_m_s(0.2 * share(random), 0.0, 0.2);
  for (int tick = 1; tick <= 100; ++tick) {
    bodies.step(Tools{
        tool_at(Vector3d(0.001, 0.0, -kTouching_m) + tick * kTick_s * velocity_m_s, velocity_m_s)});
    REQUIRE(bodies.is_plausible());
    REQUIRE(bodies.bodies()[0].twist.head<3>().norm() < 2.1 * velocity_m_s.norm());
  }
}

TEST_CASE("Spheres of a body without an inertia go on at their velocity", "[given_bodies]") {
  constexpr double kStiffness = 500.0;
  GivenState state;
  state.bodies = {{.number = 9}};
  state.spheres = {{.radius_m = kRadius_m, .own_m_s = Vector3d(0.0, 0.0, 0.1)}};
  GivenBodies bodies(ball_model(kStiffness));
  bodies.begin(state);
  double impulse = 0.0, work_J = 0.0;
  for (int tick = 1; tick <= 40; ++tick) {
    bodies.step(Tools{tool_at({0.0, 0.0, kTouching_m + 0.001})});
    const double force_N = kStiffness * std::max(0.0, 1e-4 * tick - 0.001);
    impulse -= kTick_s * force_N;
    work_J -= kTick_s * force_N * 0.1;
  }
  CHECK_THAT(bodies.push(0, 0).wrench[2], WithinAbs(impulse, 1e-9));
  CHECK_THAT(bodies.push(0, 0).work_J, WithinAbs(work_J, 1e-9));
}

/// A plate covered by spheres, its face in z = 0 of a frame that is drawn and moves evenly.
struct Plate {
  double radius_m, spacing_m, tool_m, stiffness_N_per_m;
  Eigen::Quaterniond turn;
  Vector3d velocity_m_s;

  explicit Plate(unsigned seed) {
    std::mt19937 random(seed);
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    radius_m = between(0.002, 0.004);
    spacing_m = radius_m * between(0.5, 1.0);
    tool_m = between(0.003, 0.008);
    stiffness_N_per_m = between(100.0, 2000.0);
    const auto unit = [&] { return between(-1.0, 1.0); };
    turn = Eigen::Quaterniond(unit(), unit(), unit(), unit()).normalized();
    velocity_m_s = 0.3 * Vector3d(unit(), unit(), unit());
  }
  [[nodiscard]] GivenModel model() const {
    GivenModel model = ball_model(stiffness_N_per_m);
    model.tools[0].spheres[0].radius_m = tool_m;
    return model;
  }
  [[nodiscard]] GivenState state() const {
    GivenState state;
    state.bodies = {{.number = 2}};
    state.bodies[0].twist.head<3>() = velocity_m_s;
    const int side = static_cast<int>(0.05 / spacing_m) + 1;
    for (int i = 0; i < side * side; ++i) {
      const Vector3d at_m((i % side) * spacing_m - 0.025, (i / side) * spacing_m - 0.025,
                          -radius_m);
      state.spheres.push_back(
          {.number = static_cast<std::uint32_t>(i), .radius_m = radius_m, .arm_m = turn * at_m});
    }
    return state;
  }
  [[nodiscard]] dynamics::ToolPose tool_at_m(const Vector3d& place_m, int tick) const {
    return tool_at(turn * place_m + tick * kTick_s * velocity_m_s, velocity_m_s);
  }
};

TEST_CASE("A plate pushes back by stiffness times depth, however it is covered and moves",
          "[given_bodies]") {
  constexpr double kDepth_m = 0.005;
  const unsigned seed = GENERATE(range(1U, 25U));
  const Plate plate(seed);
  CAPTURE(seed, plate.radius_m, plate.spacing_m, plate.tool_m);
  const GivenState state = plate.state();
  REQUIRE(state.spheres.size() <= kMaxGivenSpheres);
  GivenBodies bodies(plate.model());
  bodies.begin(state);
  const double right_N = plate.stiffness_N_per_m * kDepth_m;
  for (int tick = 1; tick < 400; ++tick) {  // down, then across
    const double along_m = 5e-5 * std::max(0, tick - 100);
    const double height_m = plate.tool_m + 0.001 - std::min(1.0, 0.01 * tick) * (kDepth_m + 0.001);
    const GivenBodies::Push before = bodies.push(0, 0);
    bodies.step(Tools{plate.tool_at_m({along_m - 0.007, 0.3 * along_m, height_m}, tick)});
    if (tick < 120) continue;
    const Twist wrench = (bodies.push(0, 0).wrench - before.wrench) / kTick_s;
    const Vector3d force_N = plate.turn.conjugate() * wrench.head<3>();
    REQUIRE_THAT(-force_N.z(), WithinAbs(right_N, 0.05 * right_N));
    REQUIRE(force_N.head<2>().norm() < 0.15 * right_N);
  }
}

TEST_CASE("Two hands hold a ball by friction against its weight, without creep", "[given_bodies]") {
  constexpr double kSqueeze_m = 0.001;
  const double mass_kg = GENERATE(0.005, 0.05);
  GivenModel model = ball_model(1000.0, 2);
  model.materials[0].friction = 0.7;
  model.materials[0].damping_N_s_per_m = 1.0;
  GivenState state = one_ball(mass_kg, kRadius_m);
  GivenBodies bodies(model);
  bodies.begin(state);
  double settled_m = 0.0;
  for (int tick = 0; tick < 60'000; ++tick) {
    const double in_m = std::min(1.0, 0.01 * tick) * kSqueeze_m, up_m = 2e-6 * tick;
    if (tick == 100) state.bodies[0].acceleration[2] = -9.81;
    if (tick == 100 || tick % 40 == 0) {  // as a copy begins from a snapshot
      const GivenBody& now = bodies.bodies()[0];
      state.bodies[0].centre_m = now.centre_m;
      state.bodies[0].twist = now.twist;
      state.proxies.assign(bodies.tools().proxies().begin(), bodies.tools().proxies().end());
      bodies.begin(state);
    }
    bodies.step(Tools{tool_at({in_m - kTouching_m, 0.0, up_m}, {0.0, 0.0, 2e-3}),
                      tool_at({kTouching_m - in_m, 0.0, up_m}, {0.0, 0.0, 2e-3})});
    const double beside_m = bodies.bodies()[0].centre_m.z() - up_m;
    if (tick == 2000) settled_m = beside_m;
    if (tick > 2000) REQUIRE_THAT(beside_m, WithinAbs(settled_m, 1e-5));
  }
  CHECK_THAT(settled_m, WithinAbs(-0.5 * mass_kg * 9.81 / 1000.0, 1e-4));  // both springs sag
}

TEST_CASE("A tick allocates nothing", "[given_bodies]") {
  GivenBodies bodies(ball_model(500.0, 2));
  const GivenState state = one_ball(0.1, kRadius_m);
  const Tools tools{tool_at({0.0, 0.0, 0.0249}), std::nullopt};
  const auto before = devices::allocation_count();
  bodies.begin(state);
  for (int tick = 0; tick < 10; ++tick) bodies.step(tools);
  const auto after = devices::allocation_count();
  CHECK(after == before);
}

}  // namespace
}  // namespace stillgrid::local::given_bodies_test
