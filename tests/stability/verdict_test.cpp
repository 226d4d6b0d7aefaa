#include "tests/laboratory/verdict.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/laboratory/lab_cell.hpp"

namespace stillgrid::laboratory::verdict_test {
namespace {

recording::TickRow row_at(double time_s, double x_m) {
  recording::TickRow row;
  row.time_s = time_s;
  row.position_m.x() = x_m;
  row.contacts = 1;
  return row;
}

double swing(double frequency_hz, double time_s) {
  return std::sin(2.0 * std::numbers::pi * frequency_hz * time_s);
}

/// What a loop comes to that moves so, and when it is known.
struct Judged {
  Verdict verdict;
  double time_s;
};
Judged judge(const std::function<double(double time_s)>& x_m, const VerdictRule& rule = {}) {
  VerdictWatch watch(rule);
  for (int tick = 0;; ++tick)
    if (const double time_s = 1e-3 * tick; !watch.take(row_at(time_s, x_m(time_s))))
      return {watch.verdict(), time_s};
}

TEST_CASE("A loop swings that goes to and fro by more than four encoder steps at the end",
          "[verdict]") {
  const auto even = [](double peak_to_peak_m) {
    return [=](double time_s) { return 0.5 * peak_to_peak_m * swing(7.0, time_s); };
  };
  CHECK(judge(even(121e-6)).verdict == Verdict::kSwings);
  CHECK(judge(even(119e-6)).verdict == Verdict::kStable);
  CHECK(judge(even(119e-6)).time_s == Approx(20.0));
  CHECK(judge(even(119e-6), {.window_s = 2.84}).time_s == Approx(8 * 2.84).margin(1e-3));
}

TEST_CASE("Four encoder steps are quiet and five are not, wherever they are", "[verdict]") {
  for (int offset = -1000; offset <= 1000; ++offset) {
    const auto steps = [=](int count) {
      return [=](double time_s) {
        return 30e-6 * (offset + (std::fmod(time_s, 0.4) < 0.2 ? count : 0));
      };
    };
    const VerdictRule rule = {.window_s = 1.0, .least_s = 2.0, .most_s = 4.0};
    REQUIRE(judge(steps(4), rule).verdict == Verdict::kStable);
    REQUIRE(judge(steps(5), rule).verdict == Verdict::kSwings);
  }
}

TEST_CASE("A transient that still dies away at 20 s is no swing", "[verdict]") {
  const auto dying = [](double time_s) {
    return 0.002 * std::exp(-time_s / 7.0) * swing(2.0, time_s);
  };
  REQUIRE(0.004 * std::exp(-20.0 / 7.0) > 120e-6);
  const Judged judged = judge(dying);
  CHECK(judged.verdict == Verdict::kStable);
  CHECK(judged.time_s == Approx(7.0 * std::log(0.004 / 120e-6)).margin(2.0));
}

TEST_CASE("A swing that never dies away is no transient, whatever it did before", "[verdict]") {
  const auto held_up = [](double time_s) {
    return (1e-4 + 0.002 * std::exp(-time_s / 7.0)) * swing(2.0, time_s);
  };
  CHECK(judge(held_up).verdict == Verdict::kSwings);
  const auto slowly_growing = [](double time_s) {
    return 1e-4 * std::exp(time_s / 100.0) * swing(2.0, time_s);
  };
  CHECK(judge(slowly_growing).verdict == Verdict::kSwings);
}

TEST_CASE("A slow mode is seen in two of its cycles, and not in half a second at its turn",
          "[verdict]") {
  constexpr double kFrequency_hz = 0.35;
  const auto slow = [](double time_s) { return 80e-6 * swing(kFrequency_hz, time_s + 0.47); };
  CHECK(judge(slow, {.window_s = 2.0 / kFrequency_hz}).verdict == Verdict::kSwings);
  CHECK(judge(slow, {.window_s = 0.5}).verdict == Verdict::kStable);
}

TEST_CASE("The window of a cell holds two cycles of the hand with the body on its spring",
          "[verdict]") {
  LabCell cell;
  cell.scene = "free:5";
  CHECK(rule_of(cell).window_s == Approx(4.0 * std::numbers::pi * std::sqrt(5.1 / 100.0)));
  cell.device = "hand";
  CHECK(rule_of(cell).window_s == Approx(4.0 * std::numbers::pi * std::sqrt(5.654 / 135.0)));
  cell.scene = "wall";
  cell.device = "light";
  CHECK(rule_of(cell).window_s == 1.0);
  CHECK(rule_of(cell).least_s >= 20.0);
}

TEST_CASE("A loop that ends nowhere, or apart from what it should press, is lost", "[verdict]") {
  CHECK(verdict_of(std::span<const recording::TickRow>{}) == Verdict::kNowhere);
  const double gone_m = GENERATE(std::numeric_limits<double>::quiet_NaN(), 2.0);
  const Judged gone = judge([=](double time_s) { return time_s < 3.0 ? 0.0 : gone_m; });
  CHECK(gone.verdict == Verdict::kNowhere);
  CHECK(gone.time_s == Approx(3.0));

  std::vector<recording::TickRow> rows(3001);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = row_at(1e-3 * static_cast<double>(i), 0);
  CHECK(verdict_of(rows, {.must_touch = true}) == Verdict::kStable);
  for (recording::TickRow& row : rows) row.contacts = row.time_s < 2.3 ? 1 : 0;
  CHECK(verdict_of(rows, {.must_touch = true}) == Verdict::kParted);
  CHECK(verdict_of(rows) == Verdict::kStable);
}

}  // namespace
}  // namespace stillgrid::laboratory::verdict_test
