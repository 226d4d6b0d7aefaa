// docs/cases.md, case 2.7: a device without a hand, carried by a body that moves steadily. The
// mean force is b v = 0.5 N whatever is displayed; how much it swings is the transition's doing.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "tests/shared/display/snapshot_history.hpp"
#include "tests/stability/held_loop.hpp"

namespace stillgrid::laboratory::carried_test {
namespace {

constexpr double kSpeed_m_s = 0.1;
constexpr std::uint64_t kPeriod_ns = 33'000'000, kTick_ns = 1'000'000;

struct Carried {
  double mean_N = 0.0, swing_N = 0.0, largest_step_N = 0.0, share_lost = 0.0;
};

/// Of the force over so many ticks, after as many to settle.
Carried carry(display::Transition transition, double stiffness_N_per_m, std::ptrdiff_t ticks,
              double jitter = 0.0, unsigned seed = 1) {
  display::SnapshotHistory body(transition);
  const auto switches_ns = display::switch_times_ns(1000, kPeriod_ns, jitter, seed);
  devices::PhantomModel device = make_device({.mass_kg = 0.1, .damping_N_s_per_m = 5.0});
  device.velocity_m_s.z() = kSpeed_m_s;
  const proto::SceneHeader scene = wall(stiffness_N_per_m);
  std::vector<double> forces_N;
  std::size_t next = 0;
  for (std::ptrdiff_t tick = 0; tick < 2 * ticks; ++tick) {
    const std::uint64_t now_ns = static_cast<std::uint64_t>(tick) * kTick_ns;
    for (; switches_ns[next] <= now_ns; ++next)
      body.show(switches_ns[next], kSpeed_m_s * 1e-9 * static_cast<double>(switches_ns[next]));
    forces_N.push_back(force_N(scene, devices::read_encoders(device).z() - body.at(now_ns)));
    devices::command_force(device, {0.0, 0.0, forces_N.back()});
    devices::advance_phantom(device, devices::kSubstepsPerTick);
  }
  const auto first = forces_N.end() - ticks;
  Carried seen;
  seen.mean_N = std::accumulate(first, forces_N.end(), 0.0) / static_cast<double>(ticks);
  seen.swing_N = peak_to_peak(first, forces_N.end());
  for (auto force = first; force != forces_N.end(); ++force) {
    seen.largest_step_N = std::max(seen.largest_step_N, std::abs(*force - *(force - 1)));
    if (*force == 0.0) seen.share_lost += 1.0 / static_cast<double>(ticks);
  }
  return seen;
}

TEST_CASE("2.7 A carried device is held by b v on average, whatever is displayed", "[carried]") {
  const auto transition = static_cast<display::Transition>(
      GENERATE(range(0, static_cast<int>(display::transitions().size()))));
  const double stiffness_N_per_m = GENERATE(500.0, 2000.0);
  CAPTURE(display::name_of(transition), stiffness_N_per_m);
  const double jitter = GENERATE(0.0, 0.3);
  CHECK(carry(transition, stiffness_N_per_m, 10'000, jitter).mean_N == Approx(0.5).epsilon(0.01));
}

TEST_CASE("2.7 Held snapshots shake it by 1.283 and 4.166 N, and lose it 27 and 76 % of the time",
          "[carried]") {
  const Carried soft = carry(display::Transition::kHold, 500.0, 3300),
                hard = carry(display::Transition::kHold, 2000.0, 3300);
  CHECK(soft.swing_N == Approx(1.283).epsilon(0.005));
  CHECK(hard.swing_N == Approx(4.166).epsilon(0.005));
  CHECK(soft.share_lost == Approx(0.27).margin(0.01));
  CHECK(hard.share_lost == Approx(0.76).margin(0.01));
}

TEST_CASE("2.7 Regular snapshots carry it without a tremble by linear", "[carried]") {
  const double stiffness_N_per_m = GENERATE(500.0, 2000.0);
  // The catalogue's figure is 1e-11; here the device's 20 substeps a tick round.
  CHECK(carry(display::Transition::kLinear, stiffness_N_per_m, 2000).swing_N < 1e-10);
}

/// Swings at 500 and at 2000 N/m of four seeds, the largest of each.
struct Shaken {
  double soft_N = 0.0, hard_N = 0.0, soft_step_N = 0.0, hard_step_N = 0.0;
};

Shaken shaken(display::Transition transition) {
  Shaken most;
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    const Carried soft = carry(transition, 500.0, 5000, 0.3, seed);
    const Carried hard = carry(transition, 2000.0, 5000, 0.3, seed);
    most.soft_N = std::max(most.soft_N, soft.swing_N);
    most.hard_N = std::max(most.hard_N, hard.swing_N);
    most.soft_step_N = std::max(most.soft_step_N, soft.largest_step_N);
    most.hard_step_N = std::max(most.hard_step_N, hard.largest_step_N);
  }
  return most;
}

TEST_CASE("2.7 Under jitter of 30 % linear shakes it much as hold does", "[carried]") {
  // The case's figures are one seed's that is not known, these the largest of four seeds.
  const Shaken hold = shaken(display::Transition::kHold),
               linear = shaken(display::Transition::kLinear);
  CAPTURE(hold.soft_N, hold.hard_N, linear.soft_N, linear.hard_N, linear.soft_step_N,
          linear.hard_step_N);
  CHECK(hold.soft_N == Approx(1.60).epsilon(0.1));
  CHECK(hold.hard_N == Approx(5.84).epsilon(0.3));
  CHECK(linear.soft_N == Approx(1.51).epsilon(0.1));
  CHECK(linear.hard_N == Approx(5.39).epsilon(0.15));
  CHECK(linear.soft_step_N == Approx(1.03).epsilon(0.15));
  CHECK(linear.hard_step_N == Approx(4.00).epsilon(0.15));
  CHECK(hold.hard_N > linear.hard_N);
}

}  // namespace
}  // namespace stillgrid::laboratory::carried_test
