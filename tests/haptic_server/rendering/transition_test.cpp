#include "haptic_server/rendering/transition.hpp"

#include <catch2/catch.hpp>
#include <numeric>

namespace stillgrid {
namespace {

constexpr std::uint64_t kMs = 1'000'000;

/// Images switched at 300, 333, 366 and 400 ms, but listed newest first.
proto::SnapshotHeader four_images() {
  proto::SnapshotHeader snapshot{};
  snapshot.generation = 7;
  snapshot.history_count = 4;
  snapshot.publish_time_ns = {400 * kMs, 366 * kMs, 333 * kMs, 300 * kMs};
  return snapshot;
}

TEST_CASE("Linear begins at the image before and arrives after a period like the last",
          "[transition]") {
  const proto::SnapshotHeader snapshot = four_images();
  CHECK(image_weights(Transition::kLinear, snapshot, 400 * kMs).alpha == 0.0);
  CHECK(image_weights(Transition::kLinear, snapshot, 417 * kMs).alpha == Approx(0.5));
  CHECK(image_weights(Transition::kLinear, snapshot, 434 * kMs).alpha == 1.0);
}

TEST_CASE("Linear stays at the newest image when the next is late: min, not the print's max",
          "[transition]") {
  const ImageWeights late = image_weights(Transition::kLinear, four_images(), 900 * kMs);
  CHECK(late.alpha == 1.0);
  CHECK(late.weight[0] == 1.0);
  CHECK(late.weight[1] == 0.0);
}

TEST_CASE("Hold shows the newest image only", "[transition]") {
  const std::uint64_t now_ns = GENERATE(as<std::uint64_t>(), 0, 400 * kMs, 401 * kMs, 900 * kMs);
  const ImageWeights weights = image_weights(Transition::kHold, four_images(), now_ns);
  CHECK(weights.weight == std::array<double, proto::kHistoryLength>{1.0, 0.0, 0.0, 0.0});
}

TEST_CASE("Weights are in [0, 1] and sum to one, whatever the stamps say", "[transition]") {
  proto::SnapshotHeader snapshot = four_images();
  const std::uint64_t odd_ns =
      GENERATE(as<std::uint64_t>(), 0, 1, 366 * kMs, 400 * kMs, UINT64_MAX / 2, UINT64_MAX);
  const std::uint64_t now_ns = GENERATE(as<std::uint64_t>(), 0, 399 * kMs, 450 * kMs, UINT64_MAX);
  snapshot.publish_time_ns[1] = odd_ns;
  for (const auto& weights : {image_weights(Transition::kLinear, snapshot, now_ns),
                              weights_before_switch(Transition::kLinear, snapshot, now_ns)}) {
    CHECK(std::accumulate(weights.weight.begin(), weights.weight.end(), 0.0) == 1.0);
    for (const double weight : weights.weight) {
      CHECK(weight >= 0.0);
      CHECK(weight <= 1.0);
    }
  }
}

TEST_CASE("With one image there is nothing to pass from", "[transition]") {
  proto::SnapshotHeader snapshot = four_images();
  snapshot.history_count = 1;
  CHECK(image_weights(Transition::kLinear, snapshot, 401 * kMs).weight[0] == 1.0);
}

TEST_CASE("Before a switch the older images follow the same law", "[transition]") {
  const ImageWeights before = weights_before_switch(Transition::kLinear, four_images(), 399 * kMs);
  CHECK(before.weight[0] == 0.0);
  CHECK(before.weight[1] == 1.0);  // 33 ms after its switch at 366, which followed 33 ms
  CHECK(weights_before_switch(Transition::kHold, four_images(), 399 * kMs).weight[1] == 1.0);
}

TEST_CASE("A transition's name leads back to it", "[transition]") {
  for (const Transition transition : {Transition::kHold, Transition::kLinear})
    CHECK(transition_named(name_of(transition)) == transition);
  CHECK_FALSE(transition_named("cubic"));
}

TEST_CASE("Weights of an image are told by a later one's history, and still sum to one",
          "[transition]") {
  const ImageWeights weights{.weight = {0.75, 0.25, 0.0, 0.0}, .alpha = 0.75};
  using Weights = std::array<double, 4>;
  CHECK(in_later_image(weights, 0).weight == weights.weight);
  CHECK(in_later_image(weights, 1).weight == Weights{0.0, 0.75, 0.25, 0.0});
  CHECK(in_later_image(weights, 2).weight == Weights{0.0, 0.0, 0.75, 0.25});
  CHECK(in_later_image(weights, 3).weight == Weights{0.0, 0.0, 0.0, 1.0});  // beyond it the oldest
  CHECK(in_later_image(weights, UINT64_MAX).weight == Weights{0.0, 0.0, 0.0, 1.0});
}

}  // namespace
}  // namespace stillgrid
