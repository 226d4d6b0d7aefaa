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

struct Motion {
  std::function<double(double)> position_m, velocity_m_s;
};

Motion steady() {
  return {[](double t) { return kSpeed_m_s * t; }, [](double) { return kSpeed_m_s; }};
}
/// 10 mm, 2 Hz.
Motion swinging() {
  constexpr double w = 4.0 * std::numbers::pi;
  return {[](double t) { return 0.01 * std::sin(w * t); },
          [](double t) { return 0.01 * w * std::cos(w * t); }};
}
Motion accelerating(double acceleration_m_s2) {
  return {[=](double t) { return 0.5 * acceleration_m_s2 * t * t; },
          [=](double t) { return acceleration_m_s2 * t; }};
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
Seen watch(SnapshotHistory history, const Motion& motion,
           const std::vector<std::uint64_t>& times_ns, std::size_t settled = 8) {
  constexpr int kSamples = 32;
  Seen seen;
  for (std::size_t n = 0; n + 1 < times_ns.size(); ++n) {
    const std::uint64_t now_ns = times_ns[n], next_ns = times_ns[n + 1];
    const double before_m = n > 0 ? history.at(now_ns) : 0.0;
    history.show(now_ns, motion.position_m(seconds(now_ns)), motion.velocity_m_s(seconds(now_ns)));
    if (n < settled) continue;
    seen.jumps_m.push_back(history.at(now_ns) - before_m);
    double stage_s = 0.0, last_m = history.at(now_ns);
    for (std::uint64_t i = 0; i < kSamples; ++i) {
      const std::uint64_t t_ns = now_ns + i * (next_ns - now_ns) / kSamples;
      seen.displayed_m.push_back(history.at(t_ns));
      seen.true_m.push_back(motion.position_m(seconds(t_ns)));
      seen.one_period_late.push_back(motion.position_m(seconds(t_ns) - kPeriod_s));
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
  const Seen seen = watch(SnapshotHistory(Transition::kHold), steady(), regular());
  for (const double jump_m : seen.jumps_m) CHECK(jump_m == Approx(kStep_m).epsilon(1e-9));
  std::vector<double> lag_m;
  for (std::size_t i = 0; i < seen.true_m.size(); ++i)
    lag_m.push_back(seen.true_m[i] - seen.displayed_m[i]);
  CHECK(mean(lag_m) == Approx(0.5 * kStep_m).epsilon(1.0 / 31.0));
  CHECK(largest(lag_m) < kStep_m);
}

TEST_CASE("2.3 Linear, restart, hermite and playout lag by exactly v P and never jump",
          "[transition_laws]") {
  const Transition transition = GENERATE(Transition::kLinear, Transition::kRestart,
                                         Transition::kHermite, Transition::kPlayout);
  CAPTURE(name_of(transition));
  const Seen seen = watch(SnapshotHistory(transition), steady(), regular());
  CHECK(largest(seen.jumps_m) < 1e-12);
  CHECK(largest_difference(seen.displayed_m, seen.one_period_late) < 1e-10);
  CHECK(largest(seen.stage_s) == 0.0);
}

TEST_CASE("2.3 Linear cuts a sine's corners by A w^2 P^2 / 8, and so does playout",
          "[transition_laws]") {
  const Transition transition = GENERATE(Transition::kLinear, Transition::kPlayout);
  const Seen seen = watch(SnapshotHistory(transition), swinging(), regular(400));
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
  const Seen seen = watch(SnapshotHistory(Transition::kLinear), steady(), times_ns, 9);
  const double jump_m = seen.jumps_m[1], stage_s = seen.stage_s[0];
  CHECK(jump_m == Approx(off_ns < 0 ? 1e-3 : 0.0).margin(1e-12));
  CHECK(stage_s == Approx(off_ns > 0 ? 0.010 : 0.0).margin(0.043 / 32));
}

TEST_CASE("2.4 Under jitter linear jumps half of the times, by v P j / 3 and at most 2 j v P",
          "[transition_laws]") {
  constexpr double kJitter = 0.3;
  const auto seed = static_cast<unsigned>(GENERATE(1, 2, 3));
  const Seen seen = watch(SnapshotHistory(Transition::kLinear), steady(),
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
  const Seen seen = watch(SnapshotHistory(Transition::kLinear, row.estimate), steady(), regular());
  for (const double jump_m : seen.jumps_m) CHECK(jump_m == Approx(row.jump_m).margin(1e-9));
}

TEST_CASE("2.5 Restart lags by g v P, and jumps by what a history of four snapshots forgets",
          "[transition_laws]") {
  const double estimate = GENERATE(0.5, 1.0, 1.25, 1.5, 2.0);
  const double forgotten = std::pow(std::max(0.0, 1.0 - 1.0 / estimate), 3);
  CAPTURE(estimate);
  SnapshotHistory history(Transition::kRestart, estimate);
  for (const double jump_m : watch(history, steady(), regular()).jumps_m)
    CHECK(jump_m == Approx(forgotten * kStep_m).margin(1e-9));
  const auto times_ns = regular(80);
  for (const std::uint64_t now_ns : times_ns)
    history.show(now_ns, kSpeed_m_s * seconds(now_ns), kSpeed_m_s);
  CHECK(kSpeed_m_s * seconds(times_ns.back()) - history.at(times_ns.back()) ==
        Approx(std::max(estimate, 1.0) * (1.0 - forgotten) * kStep_m).epsilon(1e-6));
}

TEST_CASE("2.5 Restart's error contracts by 1 - 1/g a period, without overshoot",
          "[transition_laws]") {
  const double estimate = GENERATE(1.25, 1.5, 2.0, 3.0);
  SnapshotHistory history(Transition::kRestart, estimate);
  for (std::uint64_t n = 1; n <= 4; ++n) history.show(n * kPeriod_ns, 0.0, 0.0);
  double error_m = 1.0;  // it has moved at once, and stands
  for (std::uint64_t n = 5; n <= 7; ++n) {
    history.show(n * kPeriod_ns, 1.0, 0.0);
    CHECK(1.0 - history.at(n * kPeriod_ns) == Approx(error_m).epsilon(1e-6));
    error_m *= 1.0 - 1.0 / estimate;
  }
}

struct Break {
  double jump_m = 0.0, kink_m_s = 0.0;  // largest at switches
};

Break largest_break(Transition transition, const std::vector<std::uint64_t>& times_ns) {
  constexpr std::uint64_t kMoment_ns = 1000;
  SnapshotHistory history(transition);
  const Motion motion = swinging();
  Break most;
  for (std::size_t n = 0; n < times_ns.size(); ++n) {
    const std::uint64_t now_ns = times_ns[n];
    const double before_m = history.at(now_ns);
    const double rate_m_s = (before_m - history.at(now_ns - kMoment_ns)) * 1e6;
    history.show(now_ns, motion.position_m(seconds(now_ns)), motion.velocity_m_s(seconds(now_ns)));
    if (n < 4) continue;
    most.jump_m = std::max(most.jump_m, std::abs(history.at(now_ns) - before_m));
    const double rate_after_m_s = (history.at(now_ns + kMoment_ns) - history.at(now_ns)) * 1e6;
    most.kink_m_s = std::max(most.kink_m_s, std::abs(rate_after_m_s - rate_m_s));
  }
  return most;
}

TEST_CASE(
    "2.6 Restart and hermite do not jump at an early snapshot, and hermite has no kink either",
    "[transition_laws]") {
  auto times_ns = regular(200);
  for (std::size_t i = 0; i < times_ns.size(); i += 5) times_ns[i] -= 10'000'000;
  const Break restart = largest_break(Transition::kRestart, times_ns);
  const Break hermite = largest_break(Transition::kHermite, times_ns);
  const Break linear = largest_break(Transition::kLinear, times_ns);
  CHECK(restart.jump_m < 1e-12);
  CHECK(hermite.jump_m < 1e-8);    // its rate is a difference over 1 us
  CHECK(hermite.kink_m_s < 1e-4);  // what it accelerates by in 2 us
  CHECK(restart.kink_m_s > 0.02);
  CHECK(linear.jump_m > 5e-4);
}

TEST_CASE("2.6 Under jitter restart and hermite jump by less than a hundredth of hold's",
          "[transition_laws]") {
  const auto times_ns = switch_times_ns(2000, kPeriod_ns, 0.3, 4, kPeriod_ns);
  const double hold_m = largest_break(Transition::kHold, times_ns).jump_m;
  CHECK(largest_break(Transition::kRestart, times_ns).jump_m < 0.01 * hold_m);
  CHECK(largest_break(Transition::kHermite, times_ns).jump_m < 0.01 * hold_m);
  CHECK(largest_break(Transition::kLinear, times_ns).jump_m > 0.3 * hold_m);
}

TEST_CASE("2.6 Hermite follows a smooth path to a'' P^4 / 384", "[transition_laws]") {
  const Seen seen = watch(SnapshotHistory(Transition::kHermite), swinging(), regular(400));
  const double w = 4.0 * std::numbers::pi;
  const double bound_m = 0.01 * std::pow(w * kPeriod_s, 4) / 384.0;
  CHECK(bound_m == Approx(7.7e-7).epsilon(0.01));
  const double error_m = largest_difference(seen.displayed_m, seen.one_period_late);
  CHECK(error_m < 1.03 * bound_m);
  CHECK(error_m > 0.9 * bound_m);
}

/// How far beyond `beyond_m` the displayed goes in the period after the last of these snapshots.
double overshoot_m(Transition transition, const std::vector<std::pair<double, double>>& snapshots,
                   double beyond_m) {
  SnapshotHistory history(transition);
  std::uint64_t now_ns = kPeriod_ns;
  for (const auto& [position_m, velocity_m_s] : snapshots)
    history.show(now_ns += kPeriod_ns, position_m, velocity_m_s);
  double most_m = 0.0;
  for (std::uint64_t t_ns = now_ns; t_ns <= now_ns + kPeriod_ns; t_ns += 10'000)
    most_m = std::max(most_m, history.at(t_ns) - beyond_m);
  return most_m;
}

TEST_CASE("2.6 Hermite overshoots by 4/27 v P at a sudden stop, by v P / 4 at a reversal",
          "[transition_laws]") {
  const double v = kSpeed_m_s;
  const std::vector<std::pair<double, double>> moving = {
      {-3.0 * kStep_m, v}, {-2.0 * kStep_m, v}, {-kStep_m, v}, {0.0, v}};
  auto stop = moving, reversal = moving;
  stop.emplace_back(0.0, 0.0);
  reversal.emplace_back(0.0, -v);
  CHECK(overshoot_m(Transition::kHermite, stop, 0.0) == Approx(4.0 / 27.0 * kStep_m).epsilon(1e-3));
  CHECK(overshoot_m(Transition::kHermite, reversal, 0.0) == Approx(kStep_m / 4.0).epsilon(1e-3));
  CHECK(overshoot_m(Transition::kRestart, stop, 0.0) < 1e-12);
}

TEST_CASE("2.6 Extrapolation errs and jumps by a P^2 / 2, by a P^2 from backward differences",
          "[transition_laws]") {
  const Motion truly = accelerating(2.0);
  const Motion backward{truly.position_m, [&](double t) {
                          return (truly.position_m(t) - truly.position_m(t - kPeriod_s)) /
                                 kPeriod_s;
                        }};
  const double jump_m = kPeriod_s * kPeriod_s * 2.0;
  const auto seen = [&](const Motion& motion) {
    return watch(SnapshotHistory(Transition::kExtrapolate), motion, regular());
  };
  for (const double jump : seen(truly).jumps_m) CHECK(jump == Approx(0.5 * jump_m).epsilon(1e-6));
  for (const double jump : seen(backward).jumps_m) CHECK(jump == Approx(2.178e-3).epsilon(1e-3));
  CHECK(jump_m == Approx(2.178e-3));
}

TEST_CASE("2.6 Extrapolation has no lag on a steady body, and overshoots by v P at an impact",
          "[transition_laws]") {
  const Seen seen = watch(SnapshotHistory(Transition::kExtrapolate), steady(),
                          switch_times_ns(200, kPeriod_ns, 0.3, 5, 100 * kPeriod_ns));
  CHECK(largest_difference(seen.displayed_m, seen.true_m) < 1e-12);
  const double overshoot =
      overshoot_m(Transition::kExtrapolate, {{-kStep_m, kSpeed_m_s}, {0.0, kSpeed_m_s}}, 0.0);
  CHECK(overshoot == Approx(kStep_m).epsilon(1e-6));
}

TEST_CASE(
    "Predict has no lag on a steady body that is not compliant, and no jump, whatever the jitter",
    "[transition_laws]") {
  SnapshotHistory history(Transition::kPredict);
  history.predict(kPeriod_ns);
  const Seen seen =
      watch(history, steady(), switch_times_ns(200, kPeriod_ns, 0.3, 6, 100 * kPeriod_ns));
  CHECK(largest(seen.jumps_m) < 1e-12);
  CHECK(largest_difference(seen.displayed_m, seen.true_m) < 1e-12);
}

}  // namespace
}  // namespace stillgrid::display::transition_laws_test
