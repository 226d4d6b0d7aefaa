// The law of what a limit withheld: it comes back by a hand that moves, and by no energy.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/haptic_server/safety/safety_input.hpp"
#include "tests/sanitizer_cut.hpp"

namespace stillgrid::safety::withheld_force_test {
namespace {

constexpr double kRamp_s = 0.1;
constexpr double kPatience_s = 3.0;
constexpr double kAtRest_m_s = 0.02;  // along the force

/// A hand that slides along a wall and swings in and out of it, if at all, without leaving it; a
/// device that the wall does not ask too much of; a gap that a ramp follows.
struct Draw {
  double stiffness_N_per_m, resolution_m;  // of the encoders, 0: exact
  double depth_m, swing_m, phase_rad, slide_m_s;
  int swing_ticks, gap_ticks;  // of a swing; before the ramp
  double approach_m_s;
};

Draw drawn(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, unit(random));
  };
  Draw draw{};
  draw.stiffness_N_per_m = between(200.0, 4000.0);
  draw.resolution_m = seed % 2 == 0 ? 0.0 : between(5e-6, 5e-5);
  draw.depth_m = between(0.5e-3, 4e-3);
  draw.swing_m = seed % 5 == 0 ? 0.0 : draw.depth_m * between(0.3, 0.9);
  draw.phase_rad = 2.0 * std::numbers::pi * unit(random);
  draw.slide_m_s = between(0.03, 0.3);
  draw.swing_ticks = static_cast<int>(between(60.0, 500.0));
  draw.gap_ticks = static_cast<int>(200.0 * unit(random));
  draw.approach_m_s = seed % 3 == 0 ? 0.0 : between(0.03, 0.3);  // 0: begins in contact
  return draw;
}

/// Inwards, from the wall's surface.
double depth_m(const Draw& draw, int tick) {
  const double angle_rad =
      draw.phase_rad + 2.0 * std::numbers::pi * (tick % draw.swing_ticks) / draw.swing_ticks;
  const double swinging_m = draw.depth_m + draw.swing_m * std::sin(angle_rad);
  const double still_out_m =
      draw.approach_m_s > 0.0 ? 0.02 - draw.approach_m_s * kTick_s * tick : 0.0;
  const double at_m = swinging_m - std::max(0.0, still_out_m);
  if (draw.resolution_m == 0.0) return at_m;
  return draw.resolution_m * std::round(at_m / draw.resolution_m);
}

struct Felt {
  double most_given_J = -1.0;  // by a swing after the ramp, but for what comes back at rest
  double withheld = 0.0;       // most of a force, after the patience
  bool was_withheld = false;
};

Felt felt(const Draw& draw) {
  SafetyChain chain({.max_force_N = 1e3});
  Felt felt;
  double before_m = depth_m(draw, 0), given_J = 0.0;
  Wrench held;
  std::vector<double> given_by_then_J;
  const int ramped =
      std::max(draw.gap_ticks,
               draw.approach_m_s > 0.0 ? static_cast<int>(0.02 / draw.approach_m_s / kTick_s) : 0) +
      static_cast<int>(kRamp_s / kTick_s) + 1;
  const int last = ramped + static_cast<int>(kPatience_s / kTick_s) + 2 * draw.swing_ticks;
  for (int at = 0; at < last; ++at) {
    const double now_m = depth_m(draw, at);
    SafetyInput input = push(0.0, 0.0, draw.stiffness_N_per_m * std::max(0.0, now_m));
    if (now_m > 0.0) input.stiffness_N_per_m(2, 2) = draw.stiffness_N_per_m;
    input.motion.moved_m = {draw.slide_m_s * kTick_s, 0.0, before_m - now_m};
    input.velocity_m_s = input.motion.moved_m / kTick_s;
    input.device_believed = at >= draw.gap_ticks;
    const Wrench told = tick(chain, input).wrench;
    given_J += 0.5 * (work_J(held, input.motion) + work_J(told, input.motion));
    const double rendered_N = input.rendered.force_N.norm();
    if (std::abs(before_m - now_m) < kAtRest_m_s * kTick_s)
      given_J -= kTick_s * 0.5 * rendered_N * rendered_N / draw.stiffness_N_per_m;
    given_by_then_J.push_back(given_J);
    before_m = now_m;
    held = told;
    if (at < ramped) continue;
    const double share = told.force_N.norm() / std::max(1e-9, rendered_N);
    felt.was_withheld = felt.was_withheld || share < 0.9;
    if (at >= last - draw.swing_ticks) felt.withheld = std::max(felt.withheld, 1.0 - share);
    if (at - draw.swing_ticks < ramped) continue;
    const auto cycle = given_by_then_J.end() - 1;
    felt.most_given_J = std::max(felt.most_given_J, *cycle - *(cycle - draw.swing_ticks));
  }
  return felt;
}

TEST_CASE("What a ramp withheld comes back to a hand that moves, and no swing gives energy",
          "[safety_chain]") {
  int withheld = 0;
  for (unsigned seed = 1; seed <= 400 / tests::kCut; ++seed) {
    const Felt run = felt(drawn(seed));
    INFO("seed " << seed);
    CHECK(run.most_given_J <= 1e-9);
    CHECK(run.withheld <= 0.01);
    withheld += run.was_withheld ? 1 : 0;
  }
  CHECK(withheld > 100 / tests::kCut);
}

}  // namespace
}  // namespace stillgrid::safety::withheld_force_test
