#include "tests/laboratory/two_rate.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

namespace stillgrid::laboratory::two_rate::two_rate_test {
namespace {

Body free_body(double mass_kg) {
  return {1, mass_kg, 0.0};
}

/// As good as a wall, or as a body on a prescribed path.
const Body kStill{1, 1e9, 0.0};

double limit_N_per_m(const Device& device, const Body& body, const Cycle& cycle,
                     int sample_age_ticks) {
  const auto limit = stiffness_limit(Loop{device, body, cycle, sample_age_ticks});
  REQUIRE(limit);
  return limit->limit_N_per_m;
}

double held_force_limit_N_per_m(const Device& device, const Body& body, int period_ticks) {
  const auto limit = stiffness_limit([&](double contact_N_per_m) {
    return held_force_monodromy(device, body, period_ticks, contact_N_per_m);
  });
  REQUIRE(limit);
  return limit->limit_N_per_m;
}

TEST_CASE("A static body's snapshot bears what a wall at 1 kHz bears, at every rate of snapshots",
          "[two_rate]") {
  const int period_ticks = GENERATE(1, 10, 33, 100);
  const int sample_age_ticks = GENERATE_COPY(0, period_ticks);
  const display::Transition transition =
      GENERATE(display::Transition::kHold, display::Transition::kLinear);
  const Cycle cycle = cycle_of(transition, period_ticks, sample_age_ticks);

  CHECK(limit_N_per_m(kLightDevice, kStill, cycle, sample_age_ticks) ==
        Approx(10084.9).epsilon(1e-5));
  CHECK(limit_N_per_m(kDeviceInHand, kStill, cycle, sample_age_ticks) ==
        Approx(14928.6).epsilon(1e-5));
}

TEST_CASE("A force held for a period bears what a wall at the rate of snapshots bears",
          "[two_rate]") {
  const auto [device, period_ticks, expected_N_per_m] =
      GENERATE(std::tuple(kLightDevice, 10, 1099.9), std::tuple(kLightDevice, 33, 454.6),
               std::tuple(kLightDevice, 100, 119.2), std::tuple(kDeviceInHand, 10, 1521.5),
               std::tuple(kDeviceInHand, 100, 220.8));

  CHECK(held_force_limit_N_per_m(device, kStill, period_ticks) ==
        Approx(expected_N_per_m).epsilon(3e-4));
}

TEST_CASE("Late snapshots of bodies that react bear what case 1.13 says", "[two_rate]") {
  struct Row {
    Device device;
    int period_ticks;
    double mass_kg, hold, linear, force_held;
  };
  const Row row = GENERATE(values<Row>({
      {kLightDevice, 10, 0.05, 3189.6, 1571.4, 1857.7},
      {kLightDevice, 33, 0.1, 633.8, 1483.6, 413.8},
      {kLightDevice, 33, 5.0, 7330, 10508, 440},
      {kLightDevice, 100, 0.1, 780.8, 5136.8, 72.5},
      {kDeviceInHand, 10, 0.5, 10764, 3480, 4779},
      {kDeviceInHand, 33, 0.5, 1840, 813, 702},
      {kDeviceInHand, 33, 1.0, 1926, 885, 472},
      {kDeviceInHand, 100, 0.5, 373, 723, 190},
  }));
  const int period_ticks = row.period_ticks;
  const Body body = free_body(row.mass_kg);
  // Shown from T_n, made with the tool at T_(n-1).
  const auto late_N_per_m = [&](display::Transition transition) {
    return limit_N_per_m(row.device, body, cycle_of(transition, period_ticks, 0), period_ticks);
  };
  INFO(period_ticks << " ms, " << row.mass_kg << " kg");

  const double printed = 1.5e-3;  // all digits of the table
  CHECK(late_N_per_m(display::Transition::kHold) == Approx(row.hold).epsilon(printed));
  CHECK(late_N_per_m(display::Transition::kLinear) == Approx(row.linear).epsilon(printed));
  CHECK(held_force_limit_N_per_m(row.device, body, period_ticks) ==
        Approx(row.force_held).epsilon(printed));
}

/// The last stable stiffness of twenty a decade over all the bodies.
double worst_body_N_per_m(const Device& device, const Cycle& cycle, int sample_age_ticks) {
  const StiffnessGrid grid{10.0, 1e5, 81};
  double worst_N_per_m = grid.highest_N_per_m;
  for (const Body& body : reacting_bodies()) {
    const auto limit = stiffness_limit(Loop{device, body, cycle, sample_age_ticks}, grid);
    if (limit) worst_N_per_m = std::min(worst_N_per_m, limit->last_stable_N_per_m);
  }
  return worst_N_per_m;
}

TEST_CASE("Low-latency snapshots of the worst body bear what case 1.17 says", "[two_rate]") {
  struct Row {
    double step_cost;  // of the period
    std::array<double, 3> light_N_per_m, with_hand_N_per_m;
  };
  const Row row = GENERATE(values<Row>({
      {0.0, {10000, 12589, 11220}, {44668, 19953, 14125}},
      {1.0 / 3.0, {5012, 2818, 7079}, {28184, 2818, 1778}},
  }));
  const std::array<int, 3> periods_ticks = {10, 33, 100};
  for (std::size_t i = 0; i < periods_ticks.size(); ++i) {
    const int cost_ticks = static_cast<int>(std::lround(row.step_cost * periods_ticks[i]));
    const Cycle cycle = cycle_of(display::Transition::kHold, periods_ticks[i], cost_ticks);
    INFO(periods_ticks[i] << " ms, the step costs " << cost_ticks);

    CHECK(worst_body_N_per_m(kLightDevice, cycle, cost_ticks) ==
          Approx(row.light_N_per_m[i]).epsilon(1e-3));
    CHECK(worst_body_N_per_m(kDeviceInHand, cycle, cost_ticks) ==
          Approx(row.with_hand_N_per_m[i]).epsilon(1e-3));
  }
}

struct Snapshot {
  double position_m, velocity_m_s;
};

/// The snapshot after `last` of a free body, by implicit Euler against the tool as it stands.
Snapshot next_snapshot(const Snapshot& last, double mass_kg, double period_s,
                       double contact_N_per_m, double tool_m) {
  Snapshot next;
  // m (v' - v) = P K (tool - c - P v').
  next.velocity_m_s =
      (mass_kg * last.velocity_m_s + period_s * contact_N_per_m * (tool_m - last.position_m)) /
      (mass_kg + period_s * period_s * contact_N_per_m);
  next.position_m = last.position_m + period_s * next.velocity_m_s;
  return next;
}

/// A free body's loop in the time domain: the greatest force in the last tenth of a run, by that in
/// the tenth before. It checks the algebra of the matrix; that the product displays by these
/// weights is for lab_test to see.
double growth(const Loop& loop, double contact_N_per_m) {
  const int period_ticks = static_cast<int>(loop.cycle.size());
  const double period_s = period_ticks * kTick_s, mass_kg = loop.body.mass_kg;
  const HeldTick device = held_tick(loop.device);
  Eigen::Vector2d tool(1e-3, 0.0);
  std::array<Snapshot, proto::kHistoryLength + 1> snapshots{};  // newest made first
  std::array<double, 10> greatest_N{};
  const int tenth = 3000 / period_ticks * period_ticks;
  for (int tick = 0; tick < 10 * tenth; ++tick) {
    const int in_period = tick % period_ticks;
    if (in_period == 0) {
      const Snapshot next =
          next_snapshot(snapshots[0], mass_kg, period_s, contact_N_per_m, tool[0]);
      std::copy_backward(snapshots.begin(), snapshots.end() - 1, snapshots.end());
      snapshots[0] = next;
    }
    const int since_display = in_period - loop.sample_age_ticks;
    const auto k = static_cast<std::size_t>((since_display + period_ticks) % period_ticks);
    const Snapshot* const shown = snapshots.data() + (since_display < 0 ? 1 : 0);
    const double alpha = loop.cycle[k].alpha;
    const double shown_m = alpha * shown[0].position_m + (1.0 - alpha) * shown[1].position_m;
    const double force_N = contact_N_per_m * (tool[0] - shown_m);
    tool = device.transition * tool - device.input * force_N;
    double& greatest = greatest_N[static_cast<std::size_t>(tick / tenth)];
    greatest = std::max(greatest, std::abs(force_N));
  }
  return greatest_N[9] / greatest_N[8];
}

TEST_CASE("In the time domain the loop dies away below the limit and grows above it",
          "[two_rate]") {
  const Device device = GENERATE(kLightDevice, kDeviceInHand);
  const display::Transition transition =
      GENERATE(display::Transition::kHold, display::Transition::kLinear);
  const int latency_ticks = GENERATE(0, 11, 33);
  const Loop loop{device, free_body(0.1), cycle_of(transition, 33, latency_ticks), latency_ticks};
  const auto limit = stiffness_limit(loop, {10.0, 1e5, 481});
  INFO(display::name_of(transition) << ", late by " << latency_ticks << " ms, bears "
                                    << (limit ? limit->limit_N_per_m : INFINITY));

  if (!limit) {
    CHECK(growth(loop, 9e4) < 1.0);
    return;
  }
  CHECK(growth(loop, 0.97 * limit->limit_N_per_m) < 1.0);
  CHECK(growth(loop, 1.03 * limit->limit_N_per_m) > 1.0);
}

}  // namespace
}  // namespace stillgrid::laboratory::two_rate::two_rate_test
