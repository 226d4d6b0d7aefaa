// The transition that shows the past, as late as snapshots come: docs/cases.md, case 2.6.

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/shared/display/snapshot_history.hpp"

namespace stillgrid::display::playout_test {
namespace {

constexpr std::uint64_t kPeriod_ns = 33'000'000, kTick_ns = 250'000;

/// How far the time displayed is behind the present, of a body whose place is the time in seconds;
/// every quarter of a millisecond, and how it changed at switches.
struct Lags {
  std::vector<double> lag_s, jumps_s;
};

Lags lags(const std::vector<std::uint64_t>& times_ns, std::size_t settled) {
  SnapshotHistory history(Transition::kPlayout);
  Lags seen;
  for (std::size_t n = 0; n + 1 < times_ns.size(); ++n) {
    const std::uint64_t now_ns = times_ns[n];
    const double before_s = n > 0 ? history.at(now_ns) : 0.0;
    history.show(now_ns, static_cast<double>(now_ns) * 1e-9, 1.0);
    if (n < settled) continue;
    seen.jumps_s.push_back(history.at(now_ns) - before_s);
    for (std::uint64_t t_ns = now_ns; t_ns < times_ns[n + 1]; t_ns += kTick_ns)
      seen.lag_s.push_back(static_cast<double>(t_ns) * 1e-9 - history.at(t_ns));
  }
  return seen;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

TEST_CASE("Playout lags by exactly the period of regular snapshots, without jump or stage",
          "[playout]") {
  const Lags seen = lags(switch_times_ns(100, kPeriod_ns, 0.0, 1, kPeriod_ns), 4);
  CHECK(largest(seen.jumps_s) < 1e-12);
  for (const double lag_s : seen.lag_s) CHECK(lag_s == Approx(33e-3).epsilon(1e-9));
}

TEST_CASE("Under jitter playout never jumps, seldom stalls and lags by the longest period at most",
          "[playout]") {
  const auto seed = static_cast<unsigned>(GENERATE(1, 2, 3));
  const Lags seen = lags(switch_times_ns(3000, kPeriod_ns, 0.3, seed, kPeriod_ns), 4);
  CHECK(largest(seen.jumps_s) < 1e-12);
  CHECK(largest(seen.lag_s) <= 1.3 * 33e-3);
  double stages = 0.0, quickest = 0.0, slowest = 0.0;
  for (std::size_t i = 1; i < seen.lag_s.size(); ++i) {
    const double change = (seen.lag_s[i] - seen.lag_s[i - 1]) / 250e-6;
    if (change > 0.11) stages += 1.0;  // slower than a lag that is being raised
    quickest = std::min(quickest, change);
    slowest = std::max(slowest, change);
  }
  CHECK(stages / static_cast<double>(seen.lag_s.size()) < 0.005);
  CHECK(quickest > -0.1001);
  CHECK(slowest <= 1.0001);  // it stands, and never goes back
}

TEST_CASE("Playout takes back what a late snapshot cost it, a tenth slower or faster at most",
          "[playout]") {
  auto times_ns = switch_times_ns(800, kPeriod_ns, 0.0, 1, kPeriod_ns);
  for (std::size_t i = 20; i < times_ns.size(); ++i) times_ns[i] += 12'000'000;
  const Lags seen = lags(times_ns, 19);
  CHECK(largest(seen.jumps_s) < 1e-12);
  CHECK(largest(seen.lag_s) == Approx(45e-3).epsilon(1e-6));  // the late snapshot's
  CHECK(seen.lag_s.back() == Approx(33e-3).epsilon(1e-3));
}

TEST_CASE("Playout shows a published delay as more lag, to the nanosecond", "[playout]") {
  proto::SnapshotHeader first{}, second{};
  first.snapshot_id = 1;
  first.history_count = 1;
  first.state_time_ns.fill(100 * kTick_ns);
  first.publish_time_ns.fill(120 * kTick_ns);
  second = first;
  second.snapshot_id = second.history_count = 2;
  second.state_time_ns[0] = 200 * kTick_ns;
  second.publish_time_ns[0] = 220 * kTick_ns;
  const TransitionMemory memory =
      after_switch(Transition::kPlayout, at_first_snapshot(), first, second);
  CHECK(memory.latency_s == Approx(120 * 250e-6));
  const auto shown = [&](std::uint64_t now_ns) {
    return snapshot_weights(Transition::kPlayout, memory, second, now_ns).position;
  };
  CHECK(shown(221 * kTick_ns)[1] == Approx(0.99));
  CHECK(shown(270 * kTick_ns)[0] == Approx(0.5));
  CHECK(shown(320 * kTick_ns)[0] == Approx(1.0));
}

}  // namespace
}  // namespace stillgrid::display::playout_test
