#include "shared/display/transition.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

namespace stillgrid::display::transition_test {
namespace {

constexpr std::uint64_t kMs = 1'000'000;
using Weights = std::array<double, proto::kHistoryLength>;

/// Snapshots switched at 300, 333, 366 and 400 ms, but listed newest first.
proto::SnapshotHeader four_snapshots() {
  proto::SnapshotHeader snapshot{};
  snapshot.snapshot_id = 7;
  snapshot.history_count = 4;
  snapshot.publish_time_ns = {400 * kMs, 366 * kMs, 333 * kMs, 300 * kMs};
  snapshot.state_time_ns = snapshot.publish_time_ns;
  return snapshot;
}

SnapshotWeights shown(Transition transition, const proto::SnapshotHeader& snapshot,
                      std::uint64_t now_ns) {
  return snapshot_weights(transition, at_first_snapshot(), snapshot, now_ns);
}

Transition any_transition() {
  return static_cast<Transition>(GENERATE(range(0, static_cast<int>(transitions().size()))));
}

TEST_CASE("Linear begins at the snapshot before and arrives after a period like the last",
          "[transition]") {
  CHECK(shown(Transition::kLinear, four_snapshots(), 400 * kMs).position == Weights{0.0, 1.0});
  CHECK(shown(Transition::kLinear, four_snapshots(), 417 * kMs).alpha == Approx(0.5));
  CHECK(shown(Transition::kLinear, four_snapshots(), 434 * kMs).position == Weights{1.0});
}

TEST_CASE("Linear stays at the newest snapshot when the next is late: min, not the print's max",
          "[transition]") {
  const SnapshotWeights late = shown(Transition::kLinear, four_snapshots(), 900 * kMs);
  CHECK(late.position == Weights{1.0});
  CHECK(late.alpha == 1.0);
  CHECK(late.is_waiting);
  CHECK_FALSE(shown(Transition::kLinear, four_snapshots(), 433 * kMs).is_waiting);
}

TEST_CASE("Hold shows the newest snapshot only", "[transition]") {
  const std::uint64_t now_ns = GENERATE(as<std::uint64_t>(), 0, 400 * kMs, 401 * kMs, 900 * kMs);
  CHECK(shown(Transition::kHold, four_snapshots(), now_ns).position == Weights{1.0});
}

TEST_CASE("Weights of positions are in [0, 1] and sum to one, whatever the stamps say",
          "[transition]") {
  const Transition transition = any_transition();
  const std::uint64_t odd_ns =
      GENERATE(as<std::uint64_t>(), 0, 1, 366 * kMs, 400 * kMs, UINT64_MAX / 2, UINT64_MAX);
  const std::uint64_t now_ns = GENERATE(as<std::uint64_t>(), 0, 399 * kMs, 450 * kMs, UINT64_MAX);
  const std::size_t which = GENERATE(as<std::size_t>(), 0, 1);
  CAPTURE(name_of(transition), odd_ns, now_ns, which);
  proto::SnapshotHeader before = four_snapshots(), now = four_snapshots();
  before.publish_time_ns[which] = before.state_time_ns[which] = odd_ns;
  now.publish_time_ns[1 - which] = now.state_time_ns[which] = before.prediction_ns = odd_ns;
  now.prediction_ns = odd_ns;
  now.snapshot_id = GENERATE(as<std::uint64_t>(), 8, 9, 4);
  const TransitionMemory memory = after_switch(transition, at_first_snapshot(), before, now);
  const SnapshotWeights weights = snapshot_weights(transition, memory, now, now_ns);
  CHECK(std::accumulate(weights.position.begin(), weights.position.end(), 0.0) ==
        Approx(1.0).epsilon(1e-12));
  for (const double weight : weights.position) {
    CHECK(weight >= 0.0);
    CHECK(weight <= 1.0);
  }
  for (const double velocity_s : weights.velocity_s) CHECK(std::isfinite(velocity_s));
  CHECK(std::isfinite(weights.prediction_s));
  CHECK(weights.step_share >= 0.0);
  CHECK(weights.step_share <= 2.0);
}

TEST_CASE("With one snapshot there is nothing to pass from", "[transition]") {
  const Transition transition = any_transition();
  proto::SnapshotHeader snapshot = four_snapshots();
  snapshot.history_count = 1;
  snapshot.publish_time_ns.fill(400 * kMs);
  snapshot.state_time_ns = snapshot.publish_time_ns;
  const SnapshotWeights weights = shown(transition, snapshot, 401 * kMs);
  CHECK(weights.position == Weights{1.0});
  CHECK(weights.velocity_s[0] == 0.0);
}

TEST_CASE("A transition's name leads back to it", "[transition]") {
  const Transition transition = any_transition();
  CHECK(transition_named(name_of(transition)) == transition);
  CHECK_FALSE(transition_named("cubic"));
}

TEST_CASE("Weights of a snapshot are told by a later one's history, and still sum to one",
          "[transition]") {
  SnapshotWeights weights;
  weights.position = {0.75, 0.25, 0.0, 0.0};
  weights.velocity_s = {0.01, 0.02, 0.03};
  weights.alpha = 0.75;
  using Rates = std::array<double, proto::kHistoryLength - 1>;
  CHECK(in_later_snapshot(weights, 0).position == weights.position);
  CHECK(in_later_snapshot(weights, 1).position == Weights{0.0, 0.75, 0.25, 0.0});
  CHECK(in_later_snapshot(weights, 2).position == Weights{0.0, 0.0, 0.75, 0.25});
  CHECK(in_later_snapshot(weights, 3).position == Weights{0.0, 0.0, 0.0, 1.0});  // the oldest
  CHECK(in_later_snapshot(weights, UINT64_MAX).position == Weights{0.0, 0.0, 0.0, 1.0});
  CHECK(in_later_snapshot(weights, 1).velocity_s == Rates{0.0, 0.01, 0.02 + 0.03});
  CHECK(in_later_snapshot(weights, 7).velocity_s[2] == Approx(0.06));
}

TEST_CASE("A later history tells an earlier predicted velocity by that snapshot's velocity",
          "[transition]") {
  SnapshotWeights weights;
  weights.position[0] = 1.0;
  weights.prediction_s = 0.02;
  weights.step_share = 0.5;
  const SnapshotWeights later = in_later_snapshot(weights, 1);
  CHECK(later.velocity_s[1] == 0.02);
  CHECK(later.prediction_s == 0.0);
  CHECK(later.step_share == 0.0);
}

TEST_CASE(
    "Predict follows the predicted velocity for two periods at most, and comes to rest evenly",
    "[transition]") {
  proto::SnapshotHeader snapshot = four_snapshots();
  snapshot.prediction_ns = 32 * kMs;
  struct Row {
    std::uint64_t after_ns;
    double prediction_s, step_share;
  };
  const Row row = GENERATE(Row{0, 0.0, 0.0}, Row{8 * kMs, 0.008, 0.25}, Row{32 * kMs, 0.032, 1.0},
                           Row{48 * kMs, 0.048, 1.5}, Row{64 * kMs, 0.06, 1.875},
                           Row{80 * kMs, 0.064, 2.0}, Row{900 * kMs, 0.064, 2.0});
  const SnapshotWeights weights = shown(Transition::kPredict, snapshot, 400 * kMs + row.after_ns);
  CHECK(weights.position == Weights{1.0});
  CHECK(weights.prediction_s == Approx(row.prediction_s));
  CHECK(weights.compliance_lag_s == prediction_lag_s(0.032, 0.0));
  CHECK(weights.step_share == Approx(row.step_share));
  CHECK(weights.is_waiting == (row.after_ns >= 80 * kMs));
}

TEST_CASE("Heavy bodies are shown later than light ones, by the mass that the snapshot tells",
          "[transition]") {
  CHECK(prediction_lag_s(0.033, 0.0) == 0.006);
  CHECK(prediction_lag_s(0.033, 0.654) == Approx(0.5 * (0.006 + 0.013)));
  CHECK(prediction_lag_s(0.1, 1e6) == Approx(0.013).epsilon(1e-5));
  CHECK(prediction_lag_s(0.01, 5.0) == Approx(0.006));
  CHECK(prediction_lag_s(0.004, 5.0) == Approx(0.0024));

  proto::SnapshotHeader snapshot = four_snapshots();
  snapshot.prediction_ns = 33 * kMs;
  CHECK(responding_kg(snapshot) == 0.0);  // none responds
  snapshot.mode_count = 1;
  snapshot.modes[0].inertia_share = 1.0F;
  snapshot.largest_response = std::sqrt(3.0 * 0.033 * 0.033 / 5.0);
  CHECK(responding_kg(snapshot) == Approx(5.0));
  snapshot.modes[0].inertia_share = 0.1F;  // of the rest, springs
  CHECK(responding_kg(snapshot) == Approx(0.5));
}

TEST_CASE("No lie of a snapshot makes a lag that is none", "[transition]") {
  proto::SnapshotHeader snapshot = four_snapshots();
  snapshot.prediction_ns = 33 * kMs;
  snapshot.mode_count = GENERATE(0U, 1U, 0xffffffffU);
  snapshot.largest_response = GENERATE(std::nan(""), -1.0, 0.0, 1e-300, 1e300, 1e-3);
  snapshot.modes[0].inertia_share = static_cast<float>(GENERATE(std::nan(""), -1.0, 1e38, 1.0));
  const double lag_s = shown(Transition::kPredict, snapshot, 400 * kMs).compliance_lag_s;
  CHECK(lag_s >= 0.006);
  CHECK(lag_s <= 0.013);
}

TEST_CASE("Predict's age is of the simulated state, however late it was published",
          "[transition]") {
  proto::SnapshotHeader snapshot = four_snapshots();
  snapshot.prediction_ns = 32 * kMs;
  snapshot.state_time_ns[0] = 390 * kMs;
  CHECK(shown(Transition::kPredict, snapshot, 400 * kMs).prediction_s == Approx(0.010));
}

TEST_CASE("A snapshot that predicts nothing is held by predict", "[transition]") {
  const SnapshotWeights weights = shown(Transition::kPredict, four_snapshots(), 420 * kMs);
  CHECK(weights.position == Weights{1.0});
  CHECK(weights.prediction_s == 0.0);
  CHECK(weights.step_share == 0.0);
}

}  // namespace
}  // namespace stillgrid::display::transition_test
