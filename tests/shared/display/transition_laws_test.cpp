// What each transition shows of a body whose motion is known: docs/cases.md, 2.1 to 2.6.

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/shared/display/snapshot_history.hpp"

namespace stillgrid::display::transition_laws_test {
namespace {

constexpr std::uint64_t kPeriod_ns = 33'000'000;
constexpr double kPeriod_s = 33e-3;
constexpr double kSpeed_m_s = 0.1;
constexpr double kStep_m = kSpeed_m_s * kPeriod_s;  // v P: 3.3 mm

double seconds(std::uint64_t time_ns) {
  return static_cast<double>(time_ns) * 1e-9;
}

/// Where the body is at a time.
using Motion = double (*)(double);

double steady(double t) {
  return kSpeed_m_s * t;
}
/// 10 mm, 2 Hz.
double swinging(double t) {
  return 0.01 * std::sin(4.0 * std::numbers::pi * t);
}
/// What came of a run.
struct Seen {
  std::vector<double> jumps_m;          // at switches, signed as the speed
  std::vector<double> displayed_m;      // 32 times a period
  std::vector<double> true_m;           // likewise
  std::vector<double> one_period_late;  // likewise, of the true
  std::vector<double> stage_s;          // of each period, in which nothing moved
};

/// Shows snapshots at these instants; what came in the first `settled` of them does not count.
Seen watch(SnapshotHistory history, Motion motion, const std::vector<std::uint64_t>& times_ns,
           std::size_t settled = 8) {
  constexpr int kSamples = 32;
  Seen seen;
  for (std::size_t n = 0; n + 1 < times_ns.size(); ++n) {
    const std::uint64_t now_ns = times_ns[n], next_ns = times_ns[n + 1];
    const double before_m = n > 0 ? history.at(now_ns) : 0.0;
    history.show(now_ns, motion(seconds(now_ns)));
    if (n < settled) continue;
    seen.jumps_m.push_back(history.at(now_ns) - before_m);
    double stage_s = 0.0, last_m = history.at(now_ns);
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      const std::uint64_t t_ns = now_ns + i * (next_ns - now_ns) / kSamples;
      seen.displayed_m.push_back(history.at(t_ns));
      seen.true_m.push_back(motion(seconds(t_ns)));
      seen.one_period_late.push_back(motion(seconds(t_ns) - kPeriod_s));
      const double next_m = history.at(now_ns + (i + 1) * (next_ns - now_ns) / kSamples);
      if (std::abs(next_m - last_m) < 1e-12) stage_s += seconds(next_ns - now_ns) / kSamples;
      last_m = next_m;
    }
    seen.stage_s.push_back(stage_s);
  }
  return seen;
}

std::vector<std::uint64_t> regular(std::size_t count = 40) {
  return switch_times_ns(count, kPeriod_ns, 0.0, 1, kPeriod_ns * 100);
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}
double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}
double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST_CASE("2.2 Held snapshots jump by v P and lag by v P / 2 on average", "[transition_laws]") {
  const Seen seen = watch(SnapshotHistory(Transition::kHold), steady, regular());
  for (const double jump_m : seen.jumps_m) CHECK(jump_m == Approx(kStep_m).epsilon(1e-9));
  std::vector<double> lag_m;
  for (std::size_t i = 0; i < seen.true_m.size(); ++i)
    lag_m.push_back(seen.true_m[i] - seen.displayed_m[i]);
  CHECK(mean(lag_m) == Approx(0.5 * kStep_m).epsilon(1.0 / 31.0));
  CHECK(largest(lag_m) < kStep_m);
}

TEST_CASE("2.3 Linear lags by exactly v P and never jumps", "[transition_laws]") {
  const Seen seen = watch(SnapshotHistory(Transition::kLinear), steady, regular());
  CHECK(largest(seen.jumps_m) < 1e-12);
  CHECK(largest_difference(seen.displayed_m, seen.one_period_late) < 1e-10);
  CHECK(largest(seen.stage_s) == 0.0);
}

TEST_CASE("2.3 Linear cuts a sine's corners by A w^2 P^2 / 8", "[transition_laws]") {
  const Seen seen = watch(SnapshotHistory(Transition::kLinear), swinging, regular(400));
  const double cut_m = largest_difference(seen.displayed_m, seen.one_period_late);
  CHECK(cut_m < 0.2150e-3);
  CHECK(cut_m == Approx(0.2142e-3).epsilon(0.003));
}

TEST_CASE("2.4 Linear: an early snapshot jumps by v (P_n - P_n+1), a late one stalls for the rest",
          "[transition_laws]") {
  const std::int64_t off_ns = GENERATE(-10'000'000, 10'000'000);
  auto times_ns = regular(12);
  for (std::size_t i = 10; i < times_ns.size(); ++i)
    times_ns[i] = static_cast<std::uint64_t>(static_cast<std::int64_t>(times_ns[i]) + off_ns);
  const Seen seen = watch(SnapshotHistory(Transition::kLinear), steady, times_ns, 9);
  const double jump_m = seen.jumps_m[1], stage_s = seen.stage_s[0];
  CHECK(jump_m == Approx(off_ns < 0 ? 1e-3 : 0.0).margin(1e-12));
  CHECK(stage_s == Approx(off_ns > 0 ? 0.010 : 0.0).margin(0.043 / 32));
}

TEST_CASE("2.4 Under jitter linear jumps half of the times, by v P j / 3 and at most 2 j v P",
          "[transition_laws]") {
  constexpr double kJitter = 0.3;
  const auto seed = static_cast<unsigned>(GENERATE(1, 2, 3));
  const Seen seen = watch(SnapshotHistory(Transition::kLinear), steady,
                          switch_times_ns(20'000, kPeriod_ns, kJitter, seed, 100 * kPeriod_ns));
  double jumps = 0.0;
  for (const double jump_m : seen.jumps_m) jumps += jump_m > 1e-9 ? 1.0 : 0.0;
  CHECK(jumps / static_cast<double>(seen.jumps_m.size()) == Approx(0.5).epsilon(0.03));
  CHECK(mean(seen.jumps_m) == Approx(3.300e-4).epsilon(0.03));  // k = 1 N/m
  CHECK(largest(seen.jumps_m) < 2.0 * kJitter * kStep_m);
  CHECK(largest(seen.jumps_m) > 0.95 * 2.0 * kJitter * kStep_m);
  CHECK(mean(seen.stage_s) == Approx(kPeriod_s * kJitter / 3.0).epsilon(0.1));
}

TEST_CASE("2.5 With a wrong estimate of the period linear jumps by (1 - 1/g) v P at each switch",
          "[transition_laws]") {
  struct Row {
    double estimate, jump_m;
  };
  const Row row =
      GENERATE(Row{1.5, kStep_m / 3.0}, Row{2.0, kStep_m / 2.0}, Row{1.0, 0.0}, Row{0.5, 0.0});
  const Seen seen = watch(SnapshotHistory(Transition::kLinear, row.estimate), steady, regular());
  for (const double jump_m : seen.jumps_m) CHECK(jump_m == Approx(row.jump_m).margin(1e-9));
}

}  // namespace
}  // namespace stillgrid::display::transition_laws_test
