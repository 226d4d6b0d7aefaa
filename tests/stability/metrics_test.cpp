// Every measure on signals whose answer is known.

#include "tests/laboratory/metrics.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/laboratory/spectrum.hpp"

namespace stillgrid::laboratory::metrics_test {
namespace {

constexpr double kRate_hz = 1000.0;

/// Ten seconds along z.
template <class Function>
std::vector<Eigen::Vector3d> signal(Function value_at) {
  std::vector<Eigen::Vector3d> values(10000);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = {0.0, 0.0, value_at(static_cast<double>(i) / kRate_hz)};
  return values;
}

double sine(double frequency_hz, double time_s) {
  return std::sin(2.0 * std::numbers::pi * frequency_hz * time_s);
}

TEST_CASE("Of two hundred values the hundred-and-ninety-eighth is not exceeded by 99 %",
          "[metrics]") {
  std::vector<double> values(200);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(200 - i);
  const Extremes extremes = extremes_of(values);
  CHECK(extremes.p99 == 198.0);
  CHECK(extremes.max == 200.0);
}

TEST_CASE("The slew of an even ramp is its slope", "[metrics]") {
  const auto ramp = signal([](double time_s) { return 250.0 * time_s; });
  const Extremes slew = slew_N_per_ms(ramp, kRate_hz);
  CHECK(slew.max == Approx(0.25));
  CHECK(slew.p99 == Approx(0.25));
}

TEST_CASE("A delayed force has its delay as effective latency", "[metrics]") {
  const auto reference = signal([](double time_s) { return sine(2.0, time_s); });
  const auto delayed = signal([](double time_s) { return sine(2.0, time_s - 0.017); });
  const ForceError error = force_error(delayed, reference, kRate_hz);
  CHECK(error.lag_s == Approx(0.017));
  CHECK(error.rms_at_lag_N < 1e-9);
  // Of the difference of two sines, 2 sin(pi f d) / sqrt 2; not of whole periods, hence 2 %.
  CHECK(error.rms_N ==
        Approx(std::sqrt(2.0) * std::sin(std::numbers::pi * 2.0 * 0.017)).epsilon(0.02));
}

TEST_CASE("A force that runs ahead has no latency", "[metrics]") {
  const auto reference = signal([](double time_s) { return sine(2.0, time_s); });
  const auto early = signal([](double time_s) { return sine(2.0, time_s + 0.017); });
  CHECK(force_error(early, reference, kRate_hz).lag_s == 0.0);
}

TEST_CASE("The vibration power of a sine is half its amplitude squared", "[metrics]") {
  const double frequency_hz = GENERATE(25.0, 100.3, 333.0);
  const auto error = signal([=](double time_s) { return 0.2 * sine(frequency_hz, time_s); });
  CHECK(vibration(error, kRate_hz, 30.0).power_N2 == Approx(0.02).epsilon(0.01));
}

TEST_CASE("What a hand takes for slow motion is no vibration", "[metrics]") {
  const auto error = signal([](double time_s) { return 3.0 + sine(5.0, time_s); });
  CHECK(vibration(error, kRate_hz, 30.0).power_N2 < 1e-6);
}

TEST_CASE("A tremor at the simulation's rate is told from one beside it", "[metrics]") {
  const auto error = signal([](double time_s) { return sine(60.0, time_s) + sine(75.0, time_s); });
  const Vibration power = vibration(error, kRate_hz, 30.0);
  CHECK(power.power_N2 == Approx(1.0).epsilon(0.01));
  CHECK(power.at_harmonics_N2 == Approx(0.5).epsilon(0.01));
}

TEST_CASE("White noise spreads its power evenly", "[metrics]") {
  std::mt19937_64 random(1);
  std::normal_distribution<double> draw(0.0, 0.5);
  const auto noise = signal([&](double) { return draw(random); });
  CHECK(vibration(noise, kRate_hz, 30.0).power_N2 == Approx(0.25 * 480.0 / 500.0).epsilon(0.05));
}

TEST_CASE("A signal shorter than a segment has no spectrum", "[metrics]") {
  CHECK(welch(std::vector<double>(1023, 1.0), kRate_hz).density_per_hz.empty());
}

TEST_CASE(
    "A plateau is what stands at a snapshot, and what the next snapshot cuts off is left over",
    "[metrics]") {
  // Before the first snapshot nothing is shown; the first stands for two ticks, the second is cut
  // off at three quarters, the third stands for three.
  const std::vector<std::pair<std::uint64_t, double>> shown = {
      {0, 1.0},  {1, 0.5}, {1, 1.0}, {1, 1.0}, {2, 0.25},
      {2, 0.75}, {3, 0.0}, {3, 1.0}, {3, 1.0}, {3, 1.0}};
  std::vector<recording::TickRow> rows(shown.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    std::tie(rows[i].snapshot_id, rows[i].alpha) = shown[i];
  const Plateau found = plateau(rows, kRate_hz);
  CHECK(found.share == Approx(5.0 / 9.0));
  CHECK(found.longest_s == Approx(0.003));
  CHECK(found.left_over == Approx(0.25));
}

TEST_CASE("A jump of seven hundredths of the force there is just noticeable", "[metrics]") {
  LabRun run;
  run.rows.resize(3);
  run.rows[0].rendered_N = {0.0, 0.0, 1.9};
  run.rows[1].rendered_N = {0.0, 0.0, 2.0};
  run.jumps = {{1, 0.14}};
  const SwitchMetrics metrics = switch_metrics(run);
  CHECK(metrics.count == 1);
  CHECK(metrics.jump_N.max == Approx(0.14));
  CHECK(metrics.jump_jnd.max == Approx(1.0));
}

TEST_CASE("A jump from nothing is as noticeable as a jump can be", "[metrics]") {
  LabRun run;
  run.rows.resize(2);
  run.jumps = {{1, 1e-3}};
  CHECK(switch_metrics(run).jump_jnd.max == Approx(1.0 / kJustNoticeable));
}

}  // namespace
}  // namespace stillgrid::laboratory::metrics_test
