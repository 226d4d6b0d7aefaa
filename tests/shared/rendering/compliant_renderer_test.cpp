// The transition `predict` on snapshots whose predicted velocities and responses are written by
// hand.

#include "shared/rendering/compliant_renderer.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "haptic_server/devices/phantom_model.hpp"
#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::rendering::compliant_renderer_test {
namespace {

constexpr std::uint64_t kPeriod_ns = 32 * kMillisecond_ns;
constexpr double kPeriod_s = 32e-3, kStiffness_N_per_m = 500.0, kContactDistance_m = 0.02;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of one sphere under a tool that presses down on it.
ShownPrediction prediction(double predicted_velocity_m_s, double compliance_m_per_N, double force_N,
                           std::uint64_t period_ns = kPeriod_ns) {
  ShownPrediction shown{.period_ns = period_ns,
                        .predicted_velocity_m_s = {{0.0, 0.0, predicted_velocity_m_s}},
                        .modes = {},
                        .responses = {}};
  if (compliance_m_per_N != 0.0)
    add_mode(shown, {{0.0, 0.0, -compliance_m_per_N}}, {0.0, 0.0, -force_N});
  return shown;
}

/// A sphere of 10 mm below a tool of 10 mm.
struct Ball {
  float damping_N_s_per_m = 0.0F;
  PublishedScene scene{
      plain_scene(static_cast<float>(kStiffness_N_per_m), 0.01F, damping_N_s_per_m),
      {0.01F},
      kPeriod_ns};
  CompliantRenderer renderer = CompliantRenderer{};

  void show(double height_m, double speed_m_s, std::uint64_t time_ns, const ShownPrediction& told) {
    scene.show({{0.0, 0.0, height_m}}, {{0.0, 0.0, speed_m_s}}, time_ns, 0, told);
  }
  [[nodiscard]] RenderedTick render(double tool_m, std::uint64_t now_ns) {
    return renderer.render(scene.view(), {.position_m = {0.0, 0.0, tool_m}}, now_ns);
  }
  [[nodiscard]] double force_N(double tool_m, std::uint64_t now_ns) {
    return render(tool_m, now_ns).force.force_N.z();
  }
};

TEST_CASE("The displayed force is the one to which the sphere has given way", "[predict]") {
  constexpr double kPredictedVelocity_m_s = 0.05, kCompliance_m_per_N = 2e-3, kSnapshot_N = 1.0;
  // As for a mass that gives way so far along three directions.
  constexpr double kBall_kg = 3.0 * kPeriod_s * kPeriod_s / kCompliance_m_per_N;
  Ball ball;
  ball.show(0.0, 0.0, 0, prediction(kPredictedVelocity_m_s, kCompliance_m_per_N, kSnapshot_N));
  const auto after_ms = GENERATE(as<std::uint64_t>(), 0, 8, 16, 32, 48, 64, 200);
  const double periods =
      after_ms == 64 ? 1.875 : std::min(2.0, static_cast<double>(after_ms) / 32.0);
  // The hand presses on: F = K (depth + drift tau - share A (F - F_snapshot)), solved for F.
  const double depth_m = 0.003 + 1e-5 * static_cast<double>(after_ms);
  const double compliance_m_per_N = periods * periods * kCompliance_m_per_N;
  const double expected_N =
      kStiffness_N_per_m *
      (depth_m +
       (periods * kPeriod_s - display::prediction_lag_s(kPeriod_s, kBall_kg)) *
           kPredictedVelocity_m_s +
       compliance_m_per_N * kSnapshot_N) /
      (1.0 + kStiffness_N_per_m * compliance_m_per_N);
  // Ticks before, for a sphere gives way a quarter of the tool's radius in one at most.
  for (std::uint64_t ms = 0; ms < after_ms; ++ms)
    (void)ball.force_N(kContactDistance_m - depth_m, ms * kMillisecond_ns);
  CHECK(ball.force_N(kContactDistance_m - depth_m, after_ms * kMillisecond_ns) ==
        Approx(expected_N).margin(1e-5));
}

TEST_CASE("A sphere that is not compliant is felt where it is predicted", "[predict]") {
  Ball ball;
  ball.show(0.0, 0.1, 0, prediction(0.1, 0.0, 0.0));
  CHECK(ball.force_N(kContactDistance_m, 16 * kMillisecond_ns) ==
        Approx(500.0 * 0.0016).epsilon(1e-5));
}

TEST_CASE("Out of the tool's reach a compliance changes nothing", "[predict]") {
  Ball ball;
  ball.show(0.0, 0.0, 0, prediction(0.0, 2e-3, 0.0));
  CHECK(ball.force_N(kContactDistance_m + 1e-4, 32 * kMillisecond_ns) == 0.0);
  CHECK(ball.force_N(0.5, 33 * kMillisecond_ns) == 0.0);
}

TEST_CASE("A tool that let go is touched where the sphere was pressed up to, not beyond",
          "[predict]") {
  // In the snapshot it is pressed by 1 N; without, it would be 2 mm higher a period later.
  Ball ball;
  ball.show(0.0, 0.0, 0, prediction(0.0, 2e-3, 1.0));
  CHECK(ball.force_N(kContactDistance_m + 0.0021, 32 * kMillisecond_ns) == 0.0);
  CHECK(ball.force_N(kContactDistance_m + 0.0019, 32 * kMillisecond_ns) ==
        Approx(500.0 * 0.0001 / 2.0).epsilon(1e-3));
}

TEST_CASE(
    "A snapshot that shows a sphere elsewhere than predicted brings no jump, and soon its force",
    "[predict]") {
  const double off_m = GENERATE(-0.002, 0.0005, 0.002);
  Ball ball;
  const double tool_m = kContactDistance_m - 0.004;
  ball.show(0.0, 0.0, 0, prediction(0.01, 1e-3, 2.0));
  double last_N = 0.0;
  for (std::uint64_t ms = 0; ms < 32; ++ms) last_N = ball.force_N(tool_m, ms * kMillisecond_ns);
  ball.show(off_m, 0.0, kPeriod_ns, prediction(0.0, 0.0, 0.0));
  const RenderedTick tick = ball.render(tool_m, kPeriod_ns);
  REQUIRE(tick.is_new);
  REQUIRE(tick.switch_jump_N);
  CHECK(*tick.switch_jump_N <
        1e-3 * kStiffness_N_per_m * std::abs(off_m));  // the shift hides hold's
  double step_N = std::abs(tick.force.force_N.z() - last_N), force_N = tick.force.force_N.z();
  for (std::uint64_t ms = 33; ms < 32 + 17; ++ms) {
    const double next_N = ball.force_N(tool_m, ms * kMillisecond_ns);
    step_N = std::max(step_N, std::abs(next_N - force_N));
    force_N = next_N;
  }
  CHECK(force_N == Approx(kStiffness_N_per_m * (0.004 + off_m)).epsilon(1e-4));
  // Of what is to change, an eighth a millisecond at most.
  CHECK(step_N < 0.125 * std::abs(force_N - last_N) + 0.02);
}

TEST_CASE("A prediction errs by as much as the next snapshot lies elsewhere", "[predict]") {
  const double off_m = GENERATE(0.0, -0.001, 0.001);
  const double tool_m = kContactDistance_m - 0.004;
  Ball ball;
  for (std::uint64_t n = 0; n < 3; ++n) {
    ball.show(n < 2 ? 0.0 : off_m, 0.0, n * kPeriod_ns, prediction(0.0, 0.0, 0.0));
    const RenderedTick tick = ball.render(tool_m, n * kPeriod_ns);
    REQUIRE(tick.prediction_error.has_value() == (n > 0));
    if (n == 0) continue;
    CHECK(tick.prediction_error->distance_m == Approx(n < 2 ? 0.0 : std::abs(off_m)).margin(1e-9));
    CHECK(tick.prediction_error->force_N ==
          Approx(n < 2 ? 0.0 : kStiffness_N_per_m * std::abs(off_m)).margin(1e-6));
  }
  // The shift that still hides it is no error of the next prediction.
  ball.show(off_m, 0.0, 2 * kPeriod_ns + 8 * kMillisecond_ns, prediction(0.0, 0.0, 0.0));
  const RenderedTick tick = ball.render(tool_m, 2 * kPeriod_ns + 8 * kMillisecond_ns);
  REQUIRE(tick.prediction_error);
  CHECK(tick.prediction_error->distance_m < 1e-9);
  CHECK(tick.prediction_error->force_N < 1e-6);
}

TEST_CASE("A spring pressed at a constant speed is where it was predicted", "[predict]") {
  constexpr double kCompliance_m_per_N = 1e-3, kSpeed_m_s = 0.05;
  const auto pressed_m = [&](std::uint64_t now_ns) {
    return 0.001 + kSpeed_m_s * 1e-9 * static_cast<double>(now_ns);
  };
  Ball ball;
  for (std::uint64_t ms = 0; ms < 96; ++ms) {
    const std::uint64_t now_ns = ms * kMillisecond_ns;
    if (now_ns % kPeriod_ns == 0) {
      const double force_N =
          kStiffness_N_per_m * pressed_m(now_ns) / (1.0 + kStiffness_N_per_m * kCompliance_m_per_N);
      ShownPrediction spring = prediction(0.0, kCompliance_m_per_N, force_N);
      spring.modes.back().inertia_share = 0.0F;
      ball.show(-kCompliance_m_per_N * force_N, 0.0, now_ns, spring);
    }
    const RenderedTick tick = ball.render(kContactDistance_m - pressed_m(now_ns), now_ns);
    if (!tick.prediction_error) continue;
    CHECK(tick.prediction_error->distance_m < 1e-8);
    CHECK(tick.prediction_error->force_N < 1e-5);
  }
}

TEST_CASE("Snapshots as frequent as ticks are come to, not gone along beside", "[predict]") {
  const double off_m = GENERATE(-0.002, 0.0005, 0.002);
  const double tool_m = kContactDistance_m - 0.004;
  Ball ball;
  for (std::uint64_t ms = 0; ms < 30; ++ms) {
    ball.show(ms < 5 ? 0.0 : off_m, 0.0, ms * kMillisecond_ns,
              prediction(0.0, 1e-7, 2.0, kMillisecond_ns));
    (void)ball.force_N(tool_m, ms * kMillisecond_ns);
  }
  ball.show(off_m, 0.0, 30 * kMillisecond_ns, prediction(0.0, 1e-7, 2.0, kMillisecond_ns));
  CHECK(ball.force_N(tool_m, 30 * kMillisecond_ns) ==
        Approx(kStiffness_N_per_m * (0.004 + off_m)).epsilon(1e-3));
}

/// A free mass of 0.1 kg, drawn up by 1 N, under the tool of a light device with its hand, which
/// presses by 1 N: the device's heights. Snapshots come as late as their period is long.
std::vector<double> pressed_mass(Renderer& renderer, double stiffness_N_per_m) {
  constexpr double kMass_kg = 0.1, kPush_N = 1.0, kHand_N_per_m = 100.0, kStep_s = 0.033;
  constexpr std::uint64_t kStep_ns = 33 * kMillisecond_ns;
  PublishedScene scene(plain_scene(static_cast<float>(stiffness_N_per_m), 0.01F), {0.01F},
                       kStep_ns);
  devices::PhantomSettings settings;
  settings.device.mass_kg = 0.1;
  settings.device.damping_N_s_per_m = 5.0;
  settings.hand.stiffness_N_per_m = kHand_N_per_m;
  settings.path.kind = devices::PathKind::kStill;
  settings.path.centre_m = {0.0, 0.0, -kPush_N / kHand_N_per_m};
  settings.start_m = {0.0, 0.0, 1e-4};
  devices::PhantomModel device = devices::make_phantom(settings);
  devices::command_force(device, {0.0, 0.0, kPush_N});

  double place_m = kPush_N / stiffness_N_per_m - kContactDistance_m, speed_m_s = 0.0;
  double shown_m = place_m, shown_m_s = 0.0, shown_N = kPush_N;
  std::vector<double> heights_m;
  for (std::uint64_t tick = 0; tick < 10'000; ++tick) {
    const std::uint64_t now_ns = tick * kMillisecond_ns;
    heights_m.push_back(devices::read_encoders(device).z());
    if (tick % 33 == 0) {
      if (tick > 0) {  // the snapshot of the last sample, for its step took the whole period
        ShownPrediction told = prediction(shown_m_s + kStep_s / kMass_kg * (kPush_N - shown_N),
                                          kStep_s * kStep_s / kMass_kg, shown_N, kStep_ns);
        told.late_ns = kStep_ns;
        scene.show({{0.0, 0.0, shown_m}}, {{0.0, 0.0, shown_m_s}}, now_ns - kStep_ns, 0, told);
      }
      // Implicit Euler, with the contact at the step's end.
      const double gain = kStep_s * kStep_s / kMass_kg;
      const double free_m = place_m + kStep_s * speed_m_s + gain * kPush_N;
      const double touch_m = heights_m.back() - kContactDistance_m;
      const double end_m = free_m > touch_m ? (free_m + gain * stiffness_N_per_m * touch_m) /
                                                  (1.0 + gain * stiffness_N_per_m)
                                            : free_m;
      speed_m_s = (end_m - place_m) / kStep_s;
      place_m = shown_m = end_m;
      shown_m_s = speed_m_s;
      shown_N = std::max(0.0, stiffness_N_per_m * (end_m - touch_m));
    }
    devices::command_force(
        device, renderer.render(scene.view(), {.position_m = {0.0, 0.0, heights_m.back()}}, now_ns)
                    .force.force_N);
    devices::advance_phantom(device, devices::kSubstepsPerTick);
  }
  return heights_m;
}

TEST_CASE(
    "A free mass whose snapshots are late bears the hand with predict where hold has long failed",
    "[predict]") {
  const auto last_swing_m = [](const std::vector<double>& heights_m) {
    const auto [low, high] = std::minmax_element(heights_m.end() - 1000, heights_m.end());
    return *high - *low;
  };
  CompliantRenderer predict, stiffer;
  SnapshotRenderer hold(display::Transition::kHold), soft_hold(display::Transition::kHold);
  CHECK(last_swing_m(pressed_mass(predict, 500.0)) < 1e-5);
  CHECK(last_swing_m(pressed_mass(stiffer, 1500.0)) < 1e-5);
  CHECK(last_swing_m(pressed_mass(soft_hold, 500.0)) < 1e-5);  // 634 N/m is its limit
  CHECK(last_swing_m(pressed_mass(hold, 1500.0)) > 1e-3);
}

TEST_CASE("A tool between two bodies is given way to by each for what it presses", "[predict]") {
  // Each on a mode of its own, both pressed by 1 N in the snapshot; the tool moves up by 0.2 mm.
  constexpr double kCompliance_m_per_N = 2e-3, kSnapshot_N = 1.0, kMoved_m = 2e-4;
  PublishedScene scene(plain_scene(static_cast<float>(kStiffness_N_per_m), 0.01F), {0.01F, 0.01F},
                       kPeriod_ns);
  ShownPrediction told{.period_ns = kPeriod_ns,
                       .predicted_velocity_m_s = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()},
                       .modes = {},
                       .responses = {}};
  const Eigen::Vector3d down(0.0, 0.0, -kCompliance_m_per_N), none = Eigen::Vector3d::Zero();
  add_mode(told, {down, none}, {0.0, 0.0, -kSnapshot_N});
  add_mode(told, {-down, none}, {0.0, 0.0, kSnapshot_N});
  std::swap(told.responses[0].modes[1], told.responses[1].modes[1]);
  const double depth_m = kSnapshot_N / kStiffness_N_per_m;
  const double apart_m = kContactDistance_m - depth_m;
  scene.show({{0.0, 0.0, -apart_m}, {0.0, 0.0, apart_m}}, {none, none}, 0, 0, told);
  CompliantRenderer renderer;
  RenderedTick tick;
  for (std::uint64_t ms = 0; ms <= 32; ++ms)
    tick =
        renderer.render(scene.view(), {.position_m = {0.0, 0.0, kMoved_m}}, ms * kMillisecond_ns);
  // One gives way, the other follows: each changes by k / (1 + k c) times the way.
  const double softened_N_per_m =
      kStiffness_N_per_m / (1.0 + kStiffness_N_per_m * kCompliance_m_per_N);
  CHECK(tick.force.contacts == 2);
  CHECK(tick.force.force_N.z() == Approx(-2.0 * softened_N_per_m * kMoved_m).epsilon(1e-4));
  CHECK(tick.unsolved_N < 1e-4);
}

TEST_CASE("A sphere gives way along what it is pushed, not along what the snapshot was",
          "[predict]") {
  // Free in three directions: the tool, 45 degrees off, pushes it along the line of the centres.
  constexpr double kCompliance_m_per_N = 2e-3, kDepth_m = 0.002;
  Ball ball;
  ShownPrediction told{.period_ns = kPeriod_ns,
                       .predicted_velocity_m_s = {Eigen::Vector3d::Zero()},
                       .modes = {},
                       .responses = {}};
  for (int axis = 0; axis < 3; ++axis)
    add_mode(told, {kCompliance_m_per_N * Eigen::Vector3d::Unit(axis)}, Eigen::Vector3d::Zero());
  ball.show(0.0, 0.0, 0, told);
  const Eigen::Vector3d line = Eigen::Vector3d(1.0, 0.0, 1.0).normalized();
  RenderedTick tick;
  for (std::uint64_t ms = 0; ms <= 32; ++ms)
    tick = ball.renderer.render(ball.scene.view(),
                                {.position_m = (kContactDistance_m - kDepth_m) * line},
                                ms * kMillisecond_ns);
  const double expected_N =
      kStiffness_N_per_m * kDepth_m / (1.0 + kStiffness_N_per_m * kCompliance_m_per_N);
  CHECK((tick.force.force_N - expected_N * line).norm() < 1e-4);
}

TEST_CASE("What a tool presses is solved for in every tick, however light and rough it is",
          "[predict]") {
  // Balls of generated mass and friction, pressed off their middle, for what a period of 100 ms
  // lets them give way: with friction that did not fall with what presses, and without a way back
  // from beyond the contact, iterations went to and fro between none and all of the force.
  constexpr std::uint64_t kLong_ns = 100 * kMillisecond_ns;
  std::mt19937 random(GENERATE(range(1U, 41U)));
  std::uniform_real_distribution<double> any(0.0, 1.0);
  const double compliance_m_per_N = 1e-3 * std::pow(300.0, any(random));
  publication::StaticScene fixture = plain_scene(2000.0F, 0.01F);
  fixture.materials.front().friction = static_cast<float>(any(random));
  PublishedScene scene(fixture, {0.01F}, kLong_ns);
  ShownPrediction told{.period_ns = kLong_ns,
                       .predicted_velocity_m_s = {Eigen::Vector3d::Zero()},
                       .modes = {},
                       .responses = {}};
  for (int axis = 0; axis < 3; ++axis)
    add_mode(told, {compliance_m_per_N * Eigen::Vector3d::Unit(axis)}, Eigen::Vector3d::Zero());
  scene.show({Eigen::Vector3d::Zero()}, {Eigen::Vector3d::Zero()}, 0, 0, told);
  const double off_m = 0.016 * any(random), speed_m_s = 0.02 + 0.08 * any(random);
  const double height_m = std::sqrt(kContactDistance_m * kContactDistance_m - off_m * off_m);
  CompliantRenderer renderer;
  double before_N = 0.0, largest_N = 0.0;
  int unsolved = 0;
  for (std::uint64_t ms = 0; ms <= 100; ++ms) {
    const double way_m = speed_m_s * 1e-3 * (static_cast<double>(ms) - 30.0);
    const RenderedTick tick = renderer.render(scene.view(),
                                              {.position_m = {off_m, 0.0, height_m - way_m},
                                               .orientation = Eigen::Quaterniond::Identity(),
                                               .velocity_m_s = {0.0, 0.0, -speed_m_s},
                                               .angular_velocity_rad_s = Eigen::Vector3d::Zero()},
                                              ms * kMillisecond_ns);
    unsolved += tick.unsolved_N > 1e-3 ? 1 : 0;
    largest_N = std::max(largest_N, std::abs(tick.force.force_N.norm() - before_N));
    before_N = tick.force.force_N.norm();
  }
  CHECK(unsolved <= 1);
  CHECK(largest_N < 2000.0 * speed_m_s * 1e-3 + 0.05);
}

TEST_CASE("A header that lies about its response leaves the force finite and bounded",
          "[predict]") {
  ShownPrediction told = prediction(0.01, 1e-3, 1.0);
  const auto wrong =
      static_cast<float>(GENERATE(kNaN, kInfinity, -kInfinity, 1e30, -1.0, 1e3, 1e6));
  const int field = GENERATE(range(0, 7));
  const auto damping = GENERATE(as<float>(), proto::kOneStep, 0.0F, 0.5F);
  const auto contact_N_s_per_m = GENERATE(as<float>(), 0.0F, 1.0F);
  const auto period_ns = GENERATE(kPeriod_ns, kPeriod_ns + 1, std::uint64_t{1});
  CAPTURE(wrong, field, damping, contact_N_s_per_m, period_ns);
  told.modes[0].damping_share = damping;
  if (field == 0) told.modes[0].inertia_share = wrong;
  if (field == 1) told.modes[0].push = wrong;
  if (field == 2) told.modes[0].displacement = wrong;
  if (field == 3) told.modes[0].at_velocity = wrong;
  if (field == 4) told.responses[0].modes[0] = {wrong, wrong, wrong};
  if (field == 5) told.responses[0].modes[0][2] = wrong;
  if (field == 6) told.modes[0].damping_share = wrong;
  told.period_ns = period_ns;
  Ball ball{contact_N_s_per_m};
  const bool is_first = GENERATE(true, false);
  if (!is_first) {
    ball.show(0.0, 0.0, 0, prediction(0.01, 1e-3, 1.0));
    (void)ball.force_N(0.016, 0);
  }
  ball.show(0.0, 0.0, kPeriod_ns, told);
  constexpr double kFastest_m_s = 2.1;  // of modes, and of the sphere
  const double damper_N = contact_N_s_per_m * kFastest_m_s;
  Eigen::Vector3d last_N = Eigen::Vector3d::Zero();
  for (std::uint64_t ms = 32; ms < 120; ++ms) {
    const RenderedTick tick = ball.render(0.016, ms * kMillisecond_ns);
    CHECK(tick.force.force_N.allFinite());
    CHECK(tick.force.force_N.norm() <= 2.0 * kStiffness_N_per_m * kContactDistance_m + damper_N);
    // A quarter of the tool's radius a tick, and what is ramped out beside.
    if (ms > 32)
      CHECK((tick.force.force_N - last_N).norm() <=
            1.5 * kStiffness_N_per_m * 0.0025 + 2.0 * damper_N);
    last_N = tick.force.force_N;
  }
}

TEST_CASE("Whatever predicted velocities and responses are, the force is finite", "[predict]") {
  constexpr std::size_t kSpheres = 32;
  PublishedScene scene(plain_scene(800.0F, 0.005F), std::vector<float>(kSpheres, 0.01F),
                       kPeriod_ns);
  CompliantRenderer renderer;
  std::mt19937 random(7);
  std::normal_distribution<float> near_m(0.0F, 0.01F), part(0.0F, 0.05F);
  const std::array<float, 6> odd{std::nanf(""), 1e38F, -1e30F, 1e-30F, 1e3F, 0.0F};
  const auto any = [&] { return random() % 40 == 0 ? odd[random() % odd.size()] : part(random); };
  int touching = 0;
  for (std::uint64_t ms = 1; ms <= 2000; ++ms) {
    if (ms % 5 == 0) {
      std::vector<Eigen::Vector3d> places_m(kSpheres);
      ShownPrediction told{.period_ns = kPeriod_ns,
                           .predicted_velocity_m_s = {{kNaN, 0.0, 0.0}},
                           .modes = std::vector<proto::ResponseMode>(proto::kMaxModes),
                           .responses = std::vector<proto::SphereResponse>(kSpheres)};
      for (proto::ResponseMode& mode : told.modes)
        mode = {std::abs(any()) * 10.0F, any(), any(), any(), any()};
      for (std::size_t i = 0; i < kSpheres; ++i) {
        places_m[i] = {near_m(random), near_m(random), near_m(random)};
        for (auto& mode : told.responses[i].modes) mode = {any(), any(), any()};
      }
      scene.show(places_m, places_m, ms * kMillisecond_ns, 0, told);
    }
    const ToolPose pose{.position_m = {near_m(random), near_m(random), near_m(random)}};
    const RenderedTick tick = renderer.render(scene.view(), pose, ms * kMillisecond_ns);
    CHECK(tick.force.force_N.allFinite());
    CHECK(tick.force.torque_N_m.allFinite());
    touching += tick.force.contacts > 0 ? 1 : 0;
  }
  CHECK(touching > 500);
}

TEST_CASE("A tick of predict allocates nothing, at a switch neither", "[predict]") {
  if (!devices::allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  Ball ball;
  ball.show(0.0, 0.0, 0, prediction(0.01, 1e-3, 1.0));
  (void)ball.force_N(0.016, 0);
  ball.show(0.001, 0.0, kPeriod_ns, prediction(0.01, 1e-3, 1.0));
  const auto before = devices::allocation_count();
  double sum_N = 0.0;
  for (std::uint64_t ms = 31; ms < 64; ++ms) sum_N += ball.force_N(0.016, ms * kMillisecond_ns);
  const auto after = devices::allocation_count();
  CHECK(after == before);
  CHECK(sum_N > 0.0);
}

TEST_CASE("What only the next snapshot presses comes evenly, and pulls nothing when it has gone",
          "[predict]") {
  Ball ball;
  const ShownPrediction told = prediction(0.0, 0.0, 0.0);
  ball.show(-0.01, 0.0, 0, told);
  constexpr double kTool_m = 0.015;
  for (std::uint64_t ms = 0; ms < 32; ++ms)
    CHECK(ball.force_N(kTool_m, ms * kMillisecond_ns) == 0.0);
  ball.show(0.0, 0.0, kPeriod_ns, told);
  double before_N = 0.0;
  for (std::uint64_t ms = 32; ms < 40; ++ms) {
    const double force_N = ball.force_N(kTool_m, ms * kMillisecond_ns);
    CHECK(force_N >= before_N);
    CHECK(force_N - before_N < 0.25);
    before_N = force_N;
  }
  CHECK(before_N > 0.5);
  for (std::uint64_t ms = 40; ms < 60; ++ms) CHECK(ball.force_N(0.03, ms * kMillisecond_ns) == 0.0);
}

}  // namespace
}  // namespace stillgrid::rendering::compliant_renderer_test
