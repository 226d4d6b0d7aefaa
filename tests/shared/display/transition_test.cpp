#include "shared/display/transition.hpp"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>

namespace stillgrid::display::transition_test {
namespace {

constexpr std::uint64_t kMs = 1'000'000;

/// Snapshots switched at 366 and 400 ms.
proto::SnapshotHeader two_snapshots() {
  proto::SnapshotHeader snapshot{};
  snapshot.snapshot_id = 7;
  snapshot.history_count = 2;
  snapshot.publish_time_ns = {400 * kMs, 366 * kMs};
  snapshot.state_time_ns = snapshot.publish_time_ns;
  return snapshot;
}

Transition any_transition() {
  return static_cast<Transition>(GENERATE(range(0, static_cast<int>(transitions().size()))));
}

TEST_CASE("Linear begins at the snapshot before and arrives after a period like the last",
          "[transition]") {
  const auto alpha = [](std::uint64_t now_ns) {
    return snapshot_weights(Transition::kLinear, two_snapshots(), now_ns).alpha;
  };
  CHECK(alpha(400 * kMs) == 0.0);
  CHECK(alpha(417 * kMs) == Approx(0.5));
  CHECK(alpha(434 * kMs) == 1.0);
}

TEST_CASE("Linear stays at the newest snapshot when the next is late: min, not the print's max",
          "[transition]") {
  const SnapshotWeights late = snapshot_weights(Transition::kLinear, two_snapshots(), 900 * kMs);
  CHECK(late.alpha == 1.0);
  CHECK(late.is_waiting);
  CHECK_FALSE(snapshot_weights(Transition::kLinear, two_snapshots(), 433 * kMs).is_waiting);
}

TEST_CASE("Hold shows the newest snapshot only", "[transition]") {
  const std::uint64_t now_ns = GENERATE(as<std::uint64_t>(), 0, 400 * kMs, 401 * kMs, 900 * kMs);
  CHECK(snapshot_weights(Transition::kHold, two_snapshots(), now_ns).alpha == 1.0);
}

TEST_CASE("The weight is in [0, 1], whatever the stamps say", "[transition]") {
  const Transition transition = any_transition();
  const std::uint64_t odd_ns =
      GENERATE(as<std::uint64_t>(), 0, 1, 366 * kMs, 400 * kMs, UINT64_MAX / 2, UINT64_MAX);
  const std::uint64_t now_ns = GENERATE(as<std::uint64_t>(), 0, 399 * kMs, 450 * kMs, UINT64_MAX);
  const std::size_t which = GENERATE(as<std::size_t>(), 0, 1);
  CAPTURE(name_of(transition), odd_ns, now_ns, which);
  proto::SnapshotHeader snapshot = two_snapshots();
  snapshot.publish_time_ns[which] = snapshot.state_time_ns[1 - which] = odd_ns;
  const double alpha = snapshot_weights(transition, snapshot, now_ns).alpha;
  CHECK(alpha >= 0.0);
  CHECK(alpha <= 1.0);
}

TEST_CASE("With one snapshot there is nothing to pass from", "[transition]") {
  const Transition transition = any_transition();
  proto::SnapshotHeader snapshot = two_snapshots();
  snapshot.history_count = 1;
  snapshot.publish_time_ns.fill(400 * kMs);
  CHECK(snapshot_weights(transition, snapshot, 401 * kMs).alpha == 1.0);
}

TEST_CASE("A transition's name leads back to it", "[transition]") {
  const Transition transition = any_transition();
  CHECK(transition_named(name_of(transition)) == transition);
  CHECK_FALSE(transition_named("cubic"));
}

TEST_CASE("A later history tells a snapshot as its older one, or evenly before it",
          "[transition]") {
  const SnapshotWeights weights{.alpha = 0.75, .is_waiting = false};
  CHECK(in_later_snapshot(weights, 0).alpha == 0.75);
  CHECK(in_later_snapshot(weights, 1).alpha == -0.25);
  CHECK(in_later_snapshot({}, 1).alpha == 0.0);
  CHECK(in_later_snapshot(weights, UINT64_MAX).alpha == -1.0);
}

}  // namespace
}  // namespace stillgrid::display::transition_test
