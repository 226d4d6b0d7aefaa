// One account of both sides: what the hand gives, what the simulation books, what the interface
// makes.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "sim_server/lockstep_schedule.hpp"
#include "tests/laboratory/lab.hpp"
#include "tests/laboratory/lab_scenes.hpp"
#include "tests/laboratory/path_file.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::laboratory::interface_test {
namespace {

constexpr double kTick_s = 1e-3;

/// Presses and lets go of what is below, evenly at no time, aside of nothing.
std::vector<PathPoint> pressing_path(unsigned seed, double touch_m, double duration_s) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> rate(5.0, 17.0), depth(0.001, 0.003);
  const double slow = rate(random), fast = 2.3 * rate(random);
  const double slow_m = depth(random), fast_m = 0.4 * depth(random);
  std::vector<PathPoint> points;
  for (int tick = 0; tick * kTick_s < duration_s + 0.01; ++tick) {
    const double t_s = tick * kTick_s;
    const double z_m =
        touch_m + 0.001 - slow_m * std::sin(slow * t_s) - fast_m * std::sin(fast * t_s);
    points.push_back({t_s, {0.0, 0.0, z_m}});
  }
  return points;
}

struct Pressed {
  LabRun run;
  std::vector<sim_server::ScheduledSnapshot> shown;  // the first is that of time zero
};

Pressed press(const scene::SceneDescription& scene, const std::vector<PathPoint>& points,
              LabOptions options) {
  const PathFile path(scene.device, points);
  options.device = "replay:file=" + path.path().string();
  options.state_interval_s = 1e-6;  // every step
  Pressed pressed{.run = run_lab(scene, options), .shown = {{}}};
  sim_server::LockstepSchedule schedule(scene.period_s, options.jitter, options.seed,
                                        options.latency_s);
  const auto end_ns = static_cast<std::uint64_t>(1e9 * pressed.run.rows.back().time_s + 0.5);
  for (sim_server::ScheduledSnapshot next = schedule.next(); next.publish_ns <= end_ns;
       next = schedule.next())
    pressed.shown.push_back(next);
  return pressed;
}

/// The last tick whose tool a step can have that takes it then.
std::size_t tick_of(std::uint64_t sample_ns) {
  return static_cast<std::size_t>(sample_ns / 1'000'000);
}

double z_m(const LabRun& run, std::size_t tick) {
  return run.rows[tick].position_m.z();
}

/// Given by the hand up to a tick, by what the rows say.
double given_J(const LabRun& run, std::size_t tick) {
  double sum_J = 0.0;
  for (std::size_t i = 1; i <= tick; ++i)
    sum_J -= run.rows[i - 1].rendered_N.z() * (z_m(run, i) - z_m(run, i - 1));
  return sum_J;
}

void check_account(const Pressed& pressed, double booked_J, double tolerance_J) {
  const LabRun& run = pressed.run;
  const auto& account = run.report.interface;
  REQUIRE(account);
  const double until_J = given_J(run, tick_of(pressed.shown.back().sample_ns));
  const double now_J = given_J(run, run.rows.size() - 1);
  CHECK(account->given_by_hand_J == Approx(now_J).margin(1e-12));
  CHECK(account->in_flight_J == Approx(now_J - until_J).margin(1e-12));
  CHECK(account->booked_J == Approx(booked_J).margin(tolerance_J));
  CHECK(account->held_J == 0.0);
  CHECK(account->made_J == Approx(booked_J - until_J).margin(tolerance_J));
}

TEST_CASE("Over a wall the interface makes the leak of the hold and no more", "[interface]") {
  constexpr double kStiffness_N_per_m = 870.0;
  const auto transition = GENERATE(display::Transition::kHold, display::Transition::kLocal);
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const scene::SceneDescription scene =
        lab_scene({.body = LabBody::kWall,
                   .contact_stiffness_N_per_m = kStiffness_N_per_m,
                   .period_s = 0.031});
    const LabOptions options{.device = {}, .transition = transition, .duration_s = 3.3};
    const Pressed pressed = press(scene, pressing_path(seed, 0.0, options.duration_s), options);
    const LabRun& run = pressed.run;
    double leak_J = 0.0, depth_m = std::max(0.0, -z_m(run, 0)), leaving_J = 0.0;
    for (std::size_t i = 1; i < run.rows.size(); ++i) {
      const double next_m = std::max(0.0, -z_m(run, i)), way_m = next_m - depth_m;
      leak_J += 0.5 * kStiffness_N_per_m * way_m * way_m;
      // In a tick that leaves the wall its force is held all the way.
      if (next_m == 0.0) leaving_J += kStiffness_N_per_m * depth_m * (z_m(run, i));
      depth_m = next_m;
    }
    REQUIRE(leak_J > 1e-5);
    const auto& account = run.report.interface;
    REQUIRE(account);
    CHECK(account->booked_J == 0.0);
    CHECK(account->uncertainty_J == 0.0);
    CHECK(account->held_J == Approx(0.5 * kStiffness_N_per_m * depth_m * depth_m).margin(1e-9));
    CHECK(account->made_J == Approx(leak_J + leaving_J).margin(1e-9));  // case 1.6
  }
}

TEST_CASE("Over a body that comes on evenly hold and linear make what their lag makes",
          "[interface]") {
  // The hand's work is that of a body 0 to P late, or P; the simulation's of one in its place.
  constexpr double kStiffness_N_per_m = 640.0, kSpeed_m_s = 0.0037, kPeriod_s = 0.03;
  constexpr double kContactDistance_m = 0.016;
  const auto transition = GENERATE(display::Transition::kHold, display::Transition::kLinear);
  for (unsigned seed = 4; seed <= 6; ++seed) {
    bodies::BodyDescription pusher = sim_server::sphere({0, 0, 0}, 0.01, 0.0);
    pusher.motion = bodies::Motion::kPrescribed;
    pusher.prescribed = {.velocity_m_s = kSpeed_m_s * Eigen::Vector3d::UnitZ()};
    scene::SceneDescription scene =
        sim_server::scene_of({pusher}, sim_server::material_of(kStiffness_N_per_m));
    scene.tool = {{Eigen::Vector3d::Zero(), kContactDistance_m - 0.01}};
    scene.tool_slip_speed_m_s = scene::kPenaltySlip_m_s;  // the paper's sum
    scene.period_s = kPeriod_s;
    const LabOptions options{
        .device = {}, .transition = transition, .steps_by_samples = true, .duration_s = 2.9};
    const Pressed pressed =
        press(scene, pressing_path(seed, kContactDistance_m + 0.001, 2.9), options);
    const LabRun& run = pressed.run;
    const auto force_N = [&](std::size_t tick, double body_s) {
      return kStiffness_N_per_m *
             std::max(0.0, kContactDistance_m - (z_m(run, tick) - kSpeed_m_s * body_s));
    };
    double booked_J = 0.0, hand_J = 0.0;
    for (std::size_t k = 1; k < pressed.shown.size(); ++k) {
      const std::size_t before = tick_of(pressed.shown[k - 1].sample_ns);
      const std::size_t now = tick_of(pressed.shown[k].sample_ns);
      const double mean_N = 0.5 * (force_N(before, kTick_s * static_cast<double>(before)) +
                                   force_N(now, kTick_s * static_cast<double>(now)));
      if (k > 1) booked_J -= mean_N * (z_m(run, now) - z_m(run, before));
    }
    const std::size_t last = tick_of(pressed.shown.back().sample_ns);
    for (std::size_t i = 1; i <= last; ++i) {
      const double t_s = kTick_s * static_cast<double>(i - 1);
      const double shown_s = transition == display::Transition::kHold
                                 ? kPeriod_s * std::floor((t_s + 1e-9) / kPeriod_s)
                                 : std::max(0.0, t_s - kPeriod_s);
      hand_J -= force_N(i - 1, shown_s) * (z_m(run, i) - z_m(run, i - 1));
    }
    REQUIRE(std::abs(booked_J) > 1e-4);
    check_account(pressed, booked_J, 2e-6);
    CHECK(run.report.interface->made_J == Approx(booked_J - hand_J).margin(5e-6));
  }
}

TEST_CASE("What a body that is moved gives the hand is not taken back by control of the energy",
          "[interface]") {
  bodies::BodyDescription pusher = sim_server::sphere({0, 0, -0.012}, 0.01, 0.0);
  pusher.motion = bodies::Motion::kPrescribed;
  pusher.prescribed = {
      .direction = Eigen::Vector3d::UnitZ(), .amplitude_m = 0.0081, .frequency_hz = 1.3};
  scene::SceneDescription scene = sim_server::scene_of({pusher}, sim_server::material_of(510.0));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.005}};
  scene.period_s = 0.033;
  LabOptions options{
      .device = "phantom:profile=premium15,hand=measured,path=still,centre_z_m=0",
      .transition = GENERATE(display::Transition::kHold, display::Transition::kLinear,
                             display::Transition::kLocal),
      .duration_s = 5.1};
  options.safety.passivity_mass_kg = 0.1;
  const haptic_server::HapticReport report = run_lab(scene, options).report;
  CHECK(report.energy.given_J > 0.04);
  REQUIRE(report.interface);
  CHECK(report.interface->booked_J < -0.04);
  CHECK(report.energy.dissipated_by_control_J < 0.02 * report.energy.given_J);
}

TEST_CASE("The account books what moved a free body, however late its snapshots are",
          "[interface]") {
  // Force at a step's end by the body's change of momentum, less what draws it; the mean of both
  // ends' times the way, by the ticks' own.
  constexpr double kMass_kg = 0.137;
  struct Loop {
    display::Transition transition;
    double latency_s, jitter;
  };
  const Loop loop = GENERATE(
      Loop{display::Transition::kHold, 0.0, 0.0}, Loop{display::Transition::kLinear, 0.0, 0.3},
      Loop{display::Transition::kLinear, 0.021, 0.2}, Loop{display::Transition::kHold, 0.033, 0.3});
  for (unsigned seed = 11; seed <= 13; ++seed) {
    const scene::SceneDescription scene =
        lab_scene({.body = LabBody::kFree, .mass_kg = kMass_kg, .period_s = 0.0331});
    const LabOptions options{.device = {},
                             .transition = loop.transition,
                             .latency_s = loop.latency_s,
                             .jitter = loop.jitter,
                             .steps_by_samples = true,
                             .seed = seed,
                             .duration_s = 2.7};
    const Pressed pressed = press(scene, pressing_path(seed, 0.0, 2.7), options);
    const std::vector<WorldState>& states = pressed.run.states;
    REQUIRE(states.size() >= pressed.shown.size());
    double booked_J = 0.0, before_N = 0.0;
    for (std::size_t k = 1; k < pressed.shown.size(); ++k) {
      const double step_s = states[k].time_s - states[k - 1].time_s;
      const double pushed_N = kMass_kg *
                                  (states[k].rigid_bodies[0].velocity_m_s.z() -
                                   states[k - 1].rigid_bodies[0].velocity_m_s.z()) /
                                  step_s -
                              kMass_kg * scene.gravity_m_s2.z();
      const std::size_t now = tick_of(pressed.shown[k].sample_ns);
      // Before its first sample the tool came at its velocity.
      const double way_m = k == 1 ? step_s * pressed.run.rows[now].velocity_m_s.z()
                                  : z_m(pressed.run, now) -
                                        z_m(pressed.run, tick_of(pressed.shown[k - 1].sample_ns));
      booked_J += 0.5 * (before_N + pushed_N) * way_m;
      before_N = pushed_N;
    }
    INFO("seed " << seed);
    REQUIRE(std::abs(booked_J) > 1e-5);
    check_account(pressed, booked_J, 1e-3 * std::abs(booked_J));
  }
}

}  // namespace
}  // namespace stillgrid::laboratory::interface_test
