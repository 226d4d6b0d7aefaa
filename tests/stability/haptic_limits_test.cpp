// Where the loop of device, contact law and held force stops being stable: cases 1.1, 1.2, 1.4 and
// 1.5 of docs/cases.md, whose figures are marked so.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/shared/rendering/scene_fixture.hpp"
#include "tests/stability/held_loop.hpp"

namespace stillgrid::laboratory::haptic_limits_test {
namespace {

/// Exact for the zero-order hold without delay and virtual damping (docs/cases.md, case 1.1).
double exact_limit_N_per_m(const HeldLoop& loop) {
  const double m = loop.mass_kg, b = loop.damping_N_s_per_m, T = loop.tick_s;
  const double e = std::exp(-b * T / m);
  const double swinging = b * b * (1.0 - e) / (m * (1.0 - e) - b * T * e);
  const double flipping_divisor = b * T * (1.0 + e) - 2.0 * m * (1.0 - e);
  return flipping_divisor > 0.0 ? std::min(swinging, 2.0 * (1.0 + e) * b * b / flipping_divisor)
                                : swinging;
}

double product_limit_N_per_m(const HeldLoop& loop, double damping_N_s_per_m = 0.0,
                             VelocitySource source = VelocitySource::kBackwardDifference) {
  return first_loss_N_per_m(
      [&](double stiffness_N_per_m) {
        return tick_growth(loop, stiffness_N_per_m, damping_N_s_per_m, source);
      },
      1.0);
}

/// 20 s against a wall; unstable if the last decile still swings, and no less than the one before.
bool is_stable(const HeldLoop& loop, double push_N, double stiffness_N_per_m) {
  publication::StaticScene fixed =
      rendering::plain_scene(static_cast<float>(stiffness_N_per_m), 0.005F);
  fixed.planes = {{{0.0F, 0.0F, 1.0F}, -0.005F, 0, 0}};  // touched by the tool's origin at 0
  rendering::PublishedScene scene(fixed, {}, rendering::kMillisecond_ns);
  scene.show({}, 0);
  rendering::SnapshotRenderer renderer(display::Transition::kHold);
  devices::PhantomModel device = make_pushed_device(loop, push_N);
  const int ticks = static_cast<int>(20.0 / loop.tick_s);
  std::vector<double> height_m;
  for (int i = 0; i < ticks; ++i) {
    const Eigen::Vector3d tip_m = devices::read_encoders(device);
    height_m.push_back(tip_m.z());
    devices::command_force(device,
                           renderer.render(scene.view(), {.position_m = tip_m}, 0).force.force_N);
    devices::advance_phantom(device, devices::kSubstepsPerTick);
  }
  const auto decile = static_cast<std::ptrdiff_t>(ticks / 10);
  const double last_m = peak_to_peak(height_m.end() - decile, height_m.end());
  const double before_m = peak_to_peak(height_m.end() - 2 * decile, height_m.end() - decile);
  return last_m <= 1e-6 || last_m < 0.999 * before_m;
}

/// What the wall bears in the time domain, as a share of what it should.
double measured_share(const HeldLoop& loop, double push_N, double limit_N_per_m) {
  double stable = 0.9, unstable = 1.1;
  REQUIRE(is_stable(loop, push_N, stable * limit_N_per_m));
  REQUIRE_FALSE(is_stable(loop, push_N, unstable * limit_N_per_m));
  while (unstable - stable > 0.001) {
    const double middle = 0.5 * (stable + unstable);
    (is_stable(loop, push_N, middle * limit_N_per_m) ? stable : unstable) = middle;
  }
  return stable;
}

TEST_CASE("The tick's eigenvalues leave the unit circle at the held force's exact limit",
          "[haptic_limits]") {
  struct Row {
    HeldLoop loop;
    double published_N_per_m;
  };
  const auto [loop, published_N_per_m] =
      GENERATE(Row{{0.1, 1.0, 1e-3}, 2003.34}, Row{{0.1, 5.0, 1e-3}, 10084.03},
               Row{{0.1, 5.0, 1e-2}, 1090.50}, Row{{0.1, 5.0, 1.0 / 30.0}, 408.56},
               Row{{0.1, 5.0, 0.1}, 165.19});  // the last flips its sign every tick
  CHECK(product_limit_N_per_m(loop) == Approx(exact_limit_N_per_m(loop)).epsilon(1e-6));
  CHECK(exact_limit_N_per_m(loop) == Approx(published_N_per_m).epsilon(2e-5));
}

TEST_CASE("A device on our wall is stable up to the exact limit of the held force",
          "[haptic_limits]") {
  const HeldLoop loop = GENERATE(HeldLoop{0.1, 1.0, 1e-3}, HeldLoop{0.1, 5.0, 1e-3},
                                 HeldLoop{0.1, 5.0, 1e-2}, HeldLoop{0.1, 5.0, 0.1});
  const double share = measured_share(loop, 1.0, exact_limit_N_per_m(loop));
  // A little low, for decay takes for ever at the limit itself.
  CHECK(share > 0.97);
  CHECK(share < 1.01);
}

TEST_CASE("What a wall bears does not depend on how hard it is pushed", "[haptic_limits]") {
  const HeldLoop loop{0.1, 1.0};
  const double exact_N_per_m = exact_limit_N_per_m(loop);
  const double share = measured_share(loop, 1.0, exact_N_per_m);
  CHECK(measured_share(loop, 0.1, exact_N_per_m) == Approx(share).margin(0.002));
  CHECK(measured_share(loop, 5.0, exact_N_per_m) == Approx(share).margin(0.002));
}

TEST_CASE("A delay of ticks takes from the limit as its exact root says", "[haptic_limits]") {
  const auto [ticks, published_N_per_m] =
      GENERATE(table<int, double>({{1, 668.5}, {3, 287.4}, {10, 96.9}, {33, 31.40}}));
  const double limit_N_per_m = product_limit_N_per_m({0.1, 1.0, 1e-3, ticks});
  CHECK(limit_N_per_m == Approx(published_N_per_m).epsilon(4e-4));  // rounded there
  const double delay_s = (0.5 + ticks) * 1e-3;  // K < b / (T/2 + t_d), and its correction
  CHECK(limit_N_per_m == Approx((1.0 + delay_s / 0.6) / delay_s).epsilon(4e-3));
}

TEST_CASE("One tick of delay costs a wall two thirds of its limit", "[haptic_limits]") {
  const double share = measured_share({0.1, 1.0, 1e-3, 1}, 1.0, 668.5);
  CHECK(share > 0.97);
  CHECK(share < 1.01);
}

TEST_CASE("Virtual damping helps less than the law of short delays says", "[haptic_limits]") {
  struct Row {
    double damping_N_s_per_m;
    int delay_ticks;
    double published_N_per_m, law_N_per_m;
  };
  const Row row = GENERATE(Row{0.5, 0, 2990.0, 3000.0}, Row{1.0, 0, 3967.0, 4000.0},
                           Row{5.0, 0, 11436.6, 12000.0}, Row{20.0, 0, 34456.8, 42000.0},
                           Row{100.0, 0, 67969.0, 202000.0}, Row{20.0, 2, 5904.9, 8400.0},
                           Row{40.0, 2, 5483.0, 16400.0});
  const double limit_N_per_m =
      product_limit_N_per_m({0.1, 1.0, 1e-3, row.delay_ticks}, row.damping_N_s_per_m);
  CHECK(limit_N_per_m == Approx(row.published_N_per_m).epsilon(4e-5));
  CHECK(row.law_N_per_m ==
        Approx((1.0 + row.damping_N_s_per_m) / ((0.5 + row.delay_ticks) * 1e-3)).epsilon(1e-9));
  CHECK(limit_N_per_m < row.law_N_per_m);
}

/// What a device without damping bears with the virtual damping B = beta m / T, in units of m/T^2.
/// The damper sees backward differences through a low-pass of pole q; q = 0 gives case
/// 1.5, 2 beta (2 - beta) / (2 + beta).
///
/// The loop's polynomial (z-1)^2 (z-q) + k (z+1)(z-q) / 2 + beta (1-q) (z^2-1) / 2 has its pair of
/// roots on the unit circle where Jury's last row is zero, 1 - a1 = a0 (a0 - a2): a quadratic in k.
double z_width(double beta, double q) {
  const double pulled = beta * (1.0 - q);
  const double a = q + 0.5 * pulled, c = 2.0 - pulled;  // -a0 = a + q k/2, a0 - a2 = c - (1+q) k/2
  const double square = 0.25 * q * (1.0 + q);
  const double linear = 0.5 * (1.0 - q) + 0.5 * (1.0 + q) * a - 0.5 * q * c;
  const double constant = 2.0 * q - a * c;
  if (square == 0.0) return -constant / linear;
  return (-linear + std::sqrt(linear * linear - 4.0 * square * constant)) / (2.0 * square);
}

constexpr HeldLoop kUndamped{0.1, 0.0};
constexpr double kUnit_N_per_m = 0.1 / (1e-3 * 1e-3);  // m/T^2
constexpr double kUnit_N_s_per_m = 0.1 / 1e-3;         // m/T

TEST_CASE("Without a device's damping, stiffness over virtual damping is a closed curve",
          "[haptic_limits]") {
  const double beta = GENERATE(0.05, 0.3, 2.0 * std::sqrt(2.0) - 2.0, 1.3, 1.9);
  const double limit_N_per_m = product_limit_N_per_m(kUndamped, beta * kUnit_N_s_per_m);
  const double exact = 2.0 * beta * (2.0 - beta) / (2.0 + beta);
  CHECK(limit_N_per_m == Approx(exact * kUnit_N_per_m).epsilon(1e-6));
  CHECK(z_width(beta, 0.0) == Approx(exact).epsilon(1e-12));
  CHECK(limit_N_per_m < 68630.0);  // case 1.5: the top is 68629 N/m at 82.84 N s/m
}

TEST_CASE("Virtual damping from 2 m/T on bears no spring at all", "[haptic_limits]") {
  CHECK(tick_growth(kUndamped, 10.0, 1.99 * kUnit_N_s_per_m) < 1.0);
  CHECK(tick_growth(kUndamped, 10.0, 2.01 * kUnit_N_s_per_m) > 1.0);
}

TEST_CASE("Our velocity, 5 ms late, bears a seventh of the stiffness that a bare difference bears",
          "[haptic_limits]") {
  const double pole = std::exp(-1e-3 / 5e-3);
  const double beta = GENERATE(0.05, 0.3, 0.6, 1.3, 1.9);
  CHECK(product_limit_N_per_m(kUndamped, beta * kUnit_N_s_per_m, VelocitySource::kProduct) ==
        Approx(z_width(beta, pole) * kUnit_N_per_m).epsilon(1e-6));

  double top = 0.0;
  for (double b = 0.01; b < 2.0; b += 0.01) top = std::max(top, z_width(b, pole));
  CHECK(top * kUnit_N_per_m == Approx(9499.0).epsilon(1e-3));
  CHECK(tick_growth(kUndamped, 10.0, 1.99 * kUnit_N_s_per_m, VelocitySource::kProduct) < 1.0);
  CHECK(tick_growth(kUndamped, 10.0, 2.01 * kUnit_N_s_per_m, VelocitySource::kProduct) > 1.0);
}

}  // namespace
}  // namespace stillgrid::laboratory::haptic_limits_test
