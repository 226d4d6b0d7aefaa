#include "haptic_server/devices/band_limit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

namespace stillgrid::devices::band_limit_test {
namespace {

constexpr double kTick_s = 1e-3;

/// A sine of 1 m along x, and a steady motion along y, recorded for so many samples.
tables::Trajectory sine_recording(double frequency_hz, double rate_hz, int samples, double jitter) {
  std::mt19937 random(3);
  tables::Trajectory trajectory;
  for (int n = 0; n < samples; ++n) {
    const double off = n == 0 ? 0.0 : static_cast<double>(random() % 1000U) / 1000.0 - 0.5;
    const double time_s = (n + jitter * off) / rate_hz;
    trajectory.time_s.push_back(time_s);
    trajectory.position_m.emplace_back(
        std::sin(2.0 * std::numbers::pi * frequency_hz * time_s + 0.3), 0.1 * time_s, 0.0);
  }
  return trajectory;
}

/// How much of a frequency is in the motion along x, read once a tick.
double amplitude_m(const TrajectoryCurve& curve, double frequency_hz) {
  const int ticks = static_cast<int>(curve.knot_time_s.back() / kTick_s);
  CurveCursor cursor;
  std::complex<double> sum = 0.0;
  double weights = 0.0;
  for (int n = 0; n < ticks; ++n) {
    const double turn = 2.0 * std::numbers::pi * n / ticks;
    const double window = 0.42 - 0.5 * std::cos(turn) + 0.08 * std::cos(2.0 * turn);
    const double x_m = curve_at(curve, kTick_s * n, cursor).position_m.x();
    sum += window * x_m * std::polar(1.0, -2.0 * std::numbers::pi * frequency_hz * kTick_s * n);
    weights += window;
  }
  return 2.0 * std::abs(sum) / weights;
}

TEST_CASE("A slow recording leaves no image of its samples, evenly spaced or not", "[band_limit]") {
  const double rate_hz = GENERATE(28.6, 100.0, 400.0);
  const double jitter = GENERATE(0.0, 0.6);
  const double share = GENERATE(0.1, 0.3);  // of the rate; up to 0.35 is to pass
  const double frequency_hz = share * rate_hz;
  const tables::Trajectory trajectory = sine_recording(frequency_hz, rate_hz, 1000, jitter);
  const TrajectoryCurve limited = make_curve(trajectory, Resampling::kBandLimited, 0.0, kTick_s);
  const double image_hz = rate_hz - frequency_hz;
  CHECK(amplitude_m(limited, image_hz) < 1e-4);
  CHECK(amplitude_m(limited, frequency_hz) == Approx(1.0).margin(share < 0.2 ? 1e-3 : 0.06));

  // What it is measured beside: the spline's image, (f / (rate - f))^4 and its aliases.
  if (share == 0.3) {
    CHECK(amplitude_m(make_curve(trajectory, Resampling::kCubic), image_hz) > 0.02);
  }
}

TEST_CASE("What a fast recording holds above half the tick's rate does not fold down",
          "[band_limit]") {
  const double jitter = GENERATE(0.0, 0.6);
  const double frequency_hz = GENERATE(600.0, 700.0, 900.0);
  const tables::Trajectory trajectory = sine_recording(frequency_hz, 2000.0, 10'000, jitter);
  const double alias_hz = 1000.0 - frequency_hz;
  const TrajectoryCurve limited = make_curve(trajectory, Resampling::kBandLimited, 0.0, kTick_s);
  CHECK(amplitude_m(limited, alias_hz) < (jitter == 0.0 ? 2e-5 : 1e-2));
  CHECK(amplitude_m(make_curve(trajectory, Resampling::kCubic), alias_hz) > 0.5);
}

TEST_CASE("A fast recording passes up to 0.7 of half the tick's rate", "[band_limit]") {
  const double frequency_hz = GENERATE(1.0, 50.0, 200.0, 350.0);
  const tables::Trajectory trajectory = sine_recording(frequency_hz, 2000.0, 10'000, 0.0);
  const TrajectoryCurve limited = make_curve(trajectory, Resampling::kBandLimited, 0.0, kTick_s);
  CHECK(amplitude_m(limited, frequency_hz) == Approx(1.0).margin(0.01));
}

TEST_CASE("A band-limited curve keeps its ends, its length and a steady motion", "[band_limit]") {
  const tables::Trajectory trajectory = sine_recording(3.0, GENERATE(28.6, 2000.0), 500, 0.6);
  const TrajectoryCurve limited = make_curve(trajectory, Resampling::kBandLimited, 0.0, kTick_s);
  CHECK(limited.knot_time_s.front() == 0.0);
  CHECK(limited.knot_time_s.back() == trajectory.time_s.back());
  CHECK((limited.knot_position_m.front() - trajectory.position_m.front()).norm() < 1e-12);
  CHECK((limited.knot_position_m.back() - trajectory.position_m.back()).norm() < 1e-12);
  for (std::size_t i = 0; i < limited.knot_time_s.size(); ++i) {
    REQUIRE(limited.knot_position_m[i].y() == Approx(0.1 * limited.knot_time_s[i]).margin(1e-12));
  }
}

TEST_CASE("Of one or two samples there is nothing to limit", "[band_limit]") {
  const tables::Trajectory trajectory = sine_recording(3.0, 100.0, GENERATE(1, 2), 0.0);
  const TrajectoryCurve limited = make_curve(trajectory, Resampling::kBandLimited, 0.0, kTick_s);
  CHECK(limited.knot_position_m == trajectory.position_m);
}

}  // namespace
}  // namespace stillgrid::devices::band_limit_test
