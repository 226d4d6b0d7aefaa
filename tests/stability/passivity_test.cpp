// Energy that a held force gives, what sees it and what takes it back: cases 1.3 and 1.6 to 1.8 of
// docs/cases.md, whose figures are marked so.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "haptic_server/safety/safety_chain.hpp"
#include "tests/stability/held_loop.hpp"

namespace stillgrid::laboratory::passivity_test {
namespace {

safety::Wrench along_z(double force_N) {
  return {.force_N = {0.0, 0.0, force_N}};
}
safety::DeviceMotion moved_z(double moved_m) {
  return {.moved_m = {0.0, 0.0, moved_m}};
}

struct VirtualWall {
  double stiffness_N_per_m, damping_N_s_per_m;
  int delay_ticks;
};

/// Energy given over one round of a cyclic motion, after one round to arrive, and what a device's
/// damper of 1 N s/m takes in that round if it moves straight from tick to tick, as it must to take
/// the least.
struct Round {
  double given_J, taken_J_per_N_s_per_m;

  /// The least damping that leaves nothing.
  [[nodiscard]] double required_N_s_per_m() const { return given_J / taken_J_per_N_s_per_m; }
};

Round play(const VirtualWall& contact, const std::vector<double>& cycle_m) {
  constexpr double kTick_s = 1e-3;
  const proto::SceneHeader scene = spring(contact.stiffness_N_per_m, contact.damping_N_s_per_m);
  devices::PhantomModel motors = make_device({1.0, 0.0, kTick_s, contact.delay_ticks});
  safety::HandEnergy energy;
  double before_m = cycle_m.back(), given_before_J = 0.0, squares_m2 = 0.0;
  for (int round = 0; round < 2; ++round) {
    given_before_J = energy.given_J;
    squares_m2 = 0.0;
    for (const double now_m : cycle_m) {
      const double moved_m = now_m - std::exchange(before_m, now_m);
      safety::observe(energy, {.force_N = motors.held_force_N}, moved_z(moved_m));
      devices::command_force(motors, {0.0, 0.0, force_N(scene, now_m, moved_m / kTick_s)});
      squares_m2 += moved_m * moved_m;
    }
  }
  return {energy.given_J - given_before_J, squares_m2 / kTick_s};
}

constexpr int kTicksARound = 720;

std::vector<double> sine(int rounds) {
  std::vector<double> cycle_m;
  for (int n = 0; n < kTicksARound; ++n)
    cycle_m.push_back(0.01 * std::cos(2.0 * std::numbers::pi * rounds * n / kTicksARound));
  return cycle_m;
}

/// Colgate and Schenkel's condition with a delay of d ticks, at theta radians a tick (case 1.3).
double required_N_s_per_m(const VirtualWall& contact, double theta) {
  const double d = contact.delay_ticks;
  return 0.5e-3 * contact.stiffness_N_per_m * std::sin((d + 0.5) * theta) / std::sin(0.5 * theta) -
         contact.damping_N_s_per_m * std::cos((d + 1.0) * theta);
}

TEST_CASE("A virtual wall gives energy up to the damping that passivity requires, and none above",
          "[passivity]") {
  struct Row {
    VirtualWall contact;
    double published_N_s_per_m;
  };
  const auto [contact, published_N_s_per_m] =
      GENERATE(Row{{1000.0, 0.0, 0}, 0.5}, Row{{1000.0, 2.0, 0}, 2.5}, Row{{1000.0, -2.0, 0}, 2.5},
               Row{{1000.0, 0.0, 1}, 1.5}, Row{{1000.0, 0.0, 3}, 3.5},
               Row{{1000.0, 2.0, 1}, 2.5625}, Row{{1000.0, 2.0, 3}, 2.9353});

  double most_N_s_per_m = -std::numeric_limits<double>::infinity(), formula_error_N_s_per_m = 0.0;
  for (int rounds = 1; 2 * rounds <= kTicksARound; ++rounds) {
    const double measured_N_s_per_m = play(contact, sine(rounds)).required_N_s_per_m();
    const double theta = 2.0 * std::numbers::pi * rounds / kTicksARound;
    formula_error_N_s_per_m = std::max(
        formula_error_N_s_per_m, std::abs(measured_N_s_per_m - required_N_s_per_m(contact, theta)));
    most_N_s_per_m = std::max(most_N_s_per_m, measured_N_s_per_m);
  }
  CHECK(formula_error_N_s_per_m < 1e-6);
  CHECK(most_N_s_per_m == Approx(published_N_s_per_m).epsilon(3e-4));
  CHECK(most_N_s_per_m <= published_N_s_per_m + 1e-4);

  // Nor does any other cycle need more.
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> cycle_m(kTicksARound);
    for (double& z_m : cycle_m) z_m = 0.01 * (static_cast<double>(random()) * 0x1p-32 - 0.5);
    CHECK(play(contact, cycle_m).required_N_s_per_m() < most_N_s_per_m);
  }
}

TEST_CASE("The bounds that only add stiffness, delay and damping are wrong with a delay",
          "[passivity]") {
  double most_N_s_per_m = 0.0;
  for (int rounds = 1; 2 * rounds <= kTicksARound; ++rounds)
    most_N_s_per_m =
        std::max(most_N_s_per_m, play({1000.0, 2.0, 1}, sine(rounds)).required_N_s_per_m());
  CHECK(most_N_s_per_m > 2.55);  // K T/2 + |B| = 2.5 would leak
  CHECK(most_N_s_per_m < 2.6);   // K (T/2 + t_d) + |B| = 3.5 is more than is needed
}

/// Energy given by a wall that is entered and left at a constant speed, the mean over the places of
/// the tick in the motion.
double leak_J(double stiffness_N_per_m, double speed_m_s, double depth_m) {
  constexpr double kTick_s = 1e-3;
  constexpr int kPhases = 200;
  const proto::SceneHeader scene = wall(stiffness_N_per_m);
  const double turn_s = depth_m / speed_m_s;
  double sum_J = 0.0;
  for (int phase = 0; phase < kPhases; ++phase) {
    safety::HandEnergy energy;
    double held_N = 0.0, before_m = 0.0;
    for (double t_s = (phase + 0.5) / kPhases * kTick_s; t_s < 2.0 * turn_s + 2.0 * kTick_s;
         t_s += kTick_s) {
      const double now_m = speed_m_s * std::abs(t_s - turn_s) - depth_m;
      safety::observe(energy, along_z(held_N), moved_z(now_m - std::exchange(before_m, now_m)));
      held_N = force_N(scene, now_m);
    }
    sum_J += energy.given_J;
  }
  return sum_J / kPhases;
}

TEST_CASE("A wall gives K v T D (1 - vT / 3D) to who enters and leaves it steadily",
          "[passivity]") {
  const auto exact_J = [](double K, double v, double D) {
    return K * v * 1e-3 * D * (1.0 - v * 1e-3 / (3.0 * D));
  };
  CHECK(leak_J(1000.0, 0.1, 0.01) == Approx(exact_J(1000.0, 0.1, 0.01)).epsilon(1e-5));
  CHECK(leak_J(1000.0, 0.1, 0.01) == Approx(9.9667e-4).epsilon(1e-4));  // case 1.6
  CHECK(leak_J(2500.0, 0.3, 0.002) == Approx(exact_J(2500.0, 0.3, 0.002)).epsilon(1e-4));
  const double damper_J = 2.0 * (1000.0 * 1e-3 / 2.0) * 0.1 * 0.01;  // b = K T/2 over 2 D
  CHECK(leak_J(1000.0, 0.1, 0.01) < damper_J);
  CHECK(leak_J(1000.0, 0.1, 0.01) > 0.99 * damper_J);
}

TEST_CASE("The observed work of a held spring is its energy and half the squares of the steps",
          "[passivity]") {
  constexpr double kStiffness_N_per_m = 800.0;
  const proto::SceneHeader scene = spring(kStiffness_N_per_m);
  std::mt19937 random(7);
  safety::HandEnergy held, of_new_force;
  double before_m = 0.0, held_N = 0.0, squares_m2 = 0.0;
  for (int tick = 0; tick < 1000; ++tick) {
    const double now_m = 0.02 * (static_cast<double>(random()) * 0x1p-32 - 0.5);
    const double moved_m = now_m - std::exchange(before_m, now_m);
    safety::observe(held, along_z(held_N), moved_z(moved_m));
    held_N = force_N(scene, now_m);
    safety::observe(of_new_force, along_z(held_N), moved_z(moved_m));
    squares_m2 += moved_m * moved_m;
  }
  const double spring_J = 0.5 * kStiffness_N_per_m * before_m * before_m;
  const double hold_J = 0.5 * kStiffness_N_per_m * squares_m2;
  CHECK(held.given_J == Approx(hold_J - spring_J).epsilon(1e-9));
  CHECK(of_new_force.given_J == Approx(-hold_J - spring_J).epsilon(1e-9));
}

/// What a run against a wall came to.
struct WallRun {
  bool has_diverged = false;
  double swing_m = 0.0;  // peak to peak in the last second
  safety::HandEnergy energy;
  safety::HandEnergy really;              // of the motors' own force, over the true motion
  double most_seen_by_new_force_J = 0.0;  // the wrong observer's
};

constexpr HeldLoop kDevice{0.1, 1.0};
constexpr int kMinute_ticks = 60'000;

/// A device pushed with 1 N, through the loop's safety chain.
WallRun run_on_wall(double stiffness_N_per_m, std::optional<double> passivity_mass_kg,
                    const HeldLoop& loop = kDevice, int ticks = 10'000) {
  constexpr double kTick_s = 1e-3;
  safety::SafetyInput input{.snapshot = {true, 0.0, 0.033, true}, .elapsed_s = kTick_s};
  safety::SafetyChain chain({.max_force_N = 1e12, .passivity_mass_kg = passivity_mass_kg});
  std::uint32_t flags = 0;
  for (int tick = 0; tick < 101; ++tick) (void)chain.apply(input, flags);

  const proto::SceneHeader scene = wall(stiffness_N_per_m);
  devices::PhantomModel device = make_pushed_device(loop, 1.0);
  WallRun run;
  safety::HandEnergy of_new_force;
  std::vector<double> height_m;
  Eigen::Vector3d before_m = device.position_m;
  for (int tick = 0; tick < ticks && !run.has_diverged; ++tick) {
    const Eigen::Vector3d now_m = devices::read_encoders(device);
    input.motion = {.moved_m = now_m - before_m};
    before_m = now_m;
    input.rendered = along_z(force_N(scene, now_m.z()));
    const safety::Wrench held = chain.apply(input, flags);
    safety::observe(of_new_force, held, input.motion);
    run.most_seen_by_new_force_J = std::max(run.most_seen_by_new_force_J, of_new_force.given_J);
    devices::command_force(device, held.force_N);
    const Eigen::Vector3d truly_before_m = device.position_m;
    devices::advance_phantom(device, devices::kSubstepsPerTick);
    safety::observe(run.really, {.force_N = device.held_force_N},
                    {.moved_m = device.position_m - truly_before_m});
    height_m.push_back(now_m.z());
    run.has_diverged = std::abs(now_m.z()) > 10.0;
  }
  run.energy = chain.energy();
  if (!run.has_diverged) run.swing_m = peak_to_peak(height_m.end() - 1000, height_m.end());
  return run;
}

TEST_CASE("An observer of the new force sees nothing of a wall that buzzes for ever",
          "[passivity]") {
  const WallRun buzzing = run_on_wall(2500.0, std::nullopt);
  CHECK(buzzing.swing_m == Approx(1.5e-3).epsilon(0.1));  // case 1.8
  CHECK(buzzing.energy.given_J > 1e-3);
  CHECK(buzzing.energy.most_given_J >= buzzing.energy.given_J);
  CHECK(buzzing.most_seen_by_new_force_J < 1e-12);
  CHECK(buzzing.energy.most_given_J == Approx(buzzing.really.most_given_J).epsilon(1e-9));

  const WallRun quiet = run_on_wall(1000.0, std::nullopt);
  CHECK(quiet.swing_m < 1e-6);
}

/// The mass whose control has this cap on its damper, N s/m.
double capped(double cap_N_s_per_m) {
  return cap_N_s_per_m * 1e-3;
}

TEST_CASE("The passivity controller without a cap throws the device away", "[passivity]") {
  const double stiffness_N_per_m = GENERATE(2500.0, 5000.0, 10'000.0, 20'000.0);
  CHECK(run_on_wall(stiffness_N_per_m, capped(1e9)).has_diverged);
}

TEST_CASE("With the cap m/T walls are quiet to micrometres that buzz by millimetres without",
          "[passivity]") {
  struct Row {
    double stiffness_N_per_m, off_m, swing_m;  // case 1.8
  };
  const Row row = GENERATE(Row{2500.0, 1.5e-3, 1.6e-5}, Row{5000.0, 3.3e-3, 6.8e-6},
                           Row{10'000.0, 6.7e-3, 3.4e-6}, Row{20'000.0, 13.3e-3, 1.3e-6});
  const WallRun off = run_on_wall(row.stiffness_N_per_m, std::nullopt);
  CHECK(off.swing_m == Approx(row.off_m).epsilon(0.1));
  CHECK(off.energy.dissipated_by_control_J == 0.0);

  const WallRun on = run_on_wall(row.stiffness_N_per_m, capped(100.0));
  CHECK_FALSE(on.has_diverged);
  CHECK(on.swing_m == Approx(row.swing_m).epsilon(0.1));
  CHECK(on.energy.dissipated_by_control_J > 0.0);
  CHECK(on.energy.most_given_J < 0.1 * off.energy.most_given_J);
  CHECK(run_on_wall(row.stiffness_N_per_m, capped(100.0), kDevice, kMinute_ticks).swing_m <
        0.5 * row.swing_m);
}

TEST_CASE("The cap 2 m/T turns the device round in a tick, and fails within a minute",
          "[passivity]") {
  const double stiffness_N_per_m = GENERATE(2500.0, 5000.0, 10'000.0, 20'000.0);
  CHECK(run_on_wall(stiffness_N_per_m, capped(200.0), kDevice, kMinute_ticks).swing_m > 2e-3);
  CHECK(run_on_wall(2500.0, capped(200.0)).swing_m < 1e-4);  // not yet: a short trial is no proof
}

TEST_CASE("A cap far below m/T is too weak for the stiffest wall", "[passivity]") {
  CHECK(run_on_wall(10'000.0, capped(5.0)).swing_m < 1e-6);
  CHECK(run_on_wall(20'000.0, capped(5.0)).swing_m == Approx(4e-4).epsilon(0.1));  // case 1.8
}

TEST_CASE("A delay in the device hides most of the energy, and the control is lost",
          "[passivity]") {
  const HeldLoop late{0.1, 1.0, 1e-3, 1};
  const WallRun off = run_on_wall(2500.0, std::nullopt, late);
  CHECK(off.energy.most_given_J < 0.5 * off.really.most_given_J);
  const WallRun on = run_on_wall(2500.0, capped(100.0), late);
  CHECK(on.energy.most_given_J < 0.01 * on.really.most_given_J);
  CHECK(on.swing_m > 1e-3);
}

TEST_CASE("Encoder steps look like energy, and the control is quiet to a few steps only",
          "[passivity]") {
  const HeldLoop stepped{0.1, 1.0, 1e-3, 0, 0.0, 30e-6};
  const WallRun stiff = run_on_wall(5000.0, capped(100.0), stepped);
  CHECK(run_on_wall(5000.0, std::nullopt, stepped).swing_m > 3e-3);
  CHECK(stiff.swing_m < 5 * stepped.resolution_m);
  CHECK(stiff.energy.most_given_J > 10.0 * stiff.really.most_given_J);
  // Where the wall alone is quiet, it is no help.
  CHECK(run_on_wall(1000.0, std::nullopt, stepped).swing_m < 2 * stepped.resolution_m);
  CHECK(run_on_wall(1000.0, capped(100.0), stepped).swing_m < 5 * stepped.resolution_m);
}

}  // namespace
}  // namespace stillgrid::laboratory::passivity_test
