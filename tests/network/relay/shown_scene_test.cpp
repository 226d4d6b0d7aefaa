#include "shared/tools/scene_relay/shown_scene.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "tests/network/relay/generated_snapshots.hpp"
#include "tests/network/relay/relayed_scene.hpp"
#include "tests/network/relay/shown_history.hpp"
#include "tests/shared/publication/field_scene.hpp"

namespace stillgrid::scene_relay::shown_scene_test {
namespace {

constexpr std::uint64_t kRelay = 0xBEE;

/// A scene that a writer publishes, as it is told to the other side.
struct Told {
  explicit Told(const publication::StaticScene& scene, std::size_t moving_count)
      : writer(session.name(), scene, moving_count, 33'333'333, proto::Clock::kMonotonic, 0),
        view(view_of(session.name())),
        told(view, kRelay) {}
  publication::TestSession session;
  publication::SceneWriter writer;
  publication::SceneView view;
  ToldScene told;
};

}  // namespace

TEST_CASE("Spheres that come, go and change begin their history anew, lost snapshots are in none",
          "[shown_scene]") {
  const auto seed = GENERATE(range(1U, 6U));
  const Going going = GENERATE(from_range(std::begin(kGoings), std::end(kGoings)));
  std::mt19937 random(19 * seed);
  const std::uint32_t spheres = 30 + 43 * seed;
  publication::StaticScene fixed = publication::field_scene();
  fixed.model.assign(71, std::byte{0xA7});
  fixed.state_capacity = GeneratedSnapshots::kStateCapacity;
  const Told scene(fixed, spheres);
  RelayedScene relayed(scene.told.message());
  GeneratedSnapshots snapshots(seed, going, spheres);
  ShownHistory history;
  for (int n = 0; n < 97; ++n) {
    const ToldSnapshot& snapshot = snapshots.next();
    if (std::bernoulli_distribution(0.23)(random)) continue;
    check(snapshot, relayed.shown().limits());
    history.take(snapshot);
    const publication::SnapshotTimes times{.state_ns = snapshot.state_time_ns,
                                           .publish_ns = snapshot.publish_time_ns,
                                           .tool_ns = snapshot.tool_time_ns,
                                           .step_ns = snapshot.step_ns,
                                           .contacts = snapshot.contacts,
                                           .tool_work_J = snapshot.tool_work_J};
    relayed.shown().show(snapshot, times);
    const SeenSnapshot now = seen(relayed.view());
    INFO("seed " << seed << ", snapshot " << n);
    REQUIRE(history.wrong_in(now) == "");
    CHECK(now.header.state_time_ns[0] == times.state_ns);
    CHECK(now.header.publish_time_ns[0] == times.publish_ns);
    CHECK(now.header.tool_time_ns == times.tool_ns);
    CHECK(now.header.step_ns == times.step_ns);
    CHECK(now.header.contacts == times.contacts);
    CHECK(now.header.tool_work_J == times.tool_work_J);
  }
}

TEST_CASE("A scene with all that there is, bodies that share a field too, is shown to the byte",
          "[shown_scene]") {
  publication::StaticScene fixed = publication::field_scene();
  if (GENERATE(false, true)) {
    fixed.model.assign(1234, std::byte{0xA7});  // whatever it is: who decodes it checks it
    fixed.state_capacity = 5'003;
    fixed.hands = {GENERATE("", "left")};
  }
  fixed.name = std::string(GENERATE(0U, 1U, 62U, 63U), 'q');
  fixed.fields[1].body.rest = {
      {0.1F, 0.2F, 0.3F}, {0.0F, 0.6F, 0.0F, 0.8F}, {0.4F, 0.0F, 0.1F}, {0.0F, 0.7F, 0.0F}, 0.0F};
  for (const float half_m : {0.01F, 0.02F}) {
    fixed.fields.push_back(publication::published_field(0, 1, 11, publication::test_box(half_m)));
    fixed.fields.back().body.rest.orientation_xyzw = {0.0F, 0.6F, 0.0F, 0.8F};
  }
  const Told scene(fixed, 11);
  REQUIRE(scene.told.message().fields._length == 4);
  const RelayedScene relayed(scene.told.message());
  CHECK(first_difference(scene.view, relayed.view()) == scene.view.reader().fixed_bytes());
}

TEST_CASE("Of several hands the names are told, and no model", "[shown_scene]") {
  publication::StaticScene fixed = publication::field_scene();
  fixed.model.assign(1234, std::byte{0xA7});
  fixed.state_capacity = 5'000;
  fixed.hands = {"left", "right"};
  fixed.hand = 1;
  const Told scene(fixed, 11);
  const RelayedScene relayed(scene.told.message());
  CHECK(relayed.view().model().empty());
  CHECK(relayed.view().scene().state_capacity == 0);
  CHECK(relayed.view().scene().hand_count == 2);
  CHECK(relayed.view().scene().hand == 1);
  CHECK(relayed.view().scene().hands == scene.view.scene().hands);
}

TEST_CASE("A segment declares the period of its simulation and a round trip, the period at most",
          "[shown_scene]") {
  const Told scene(publication::field_scene(), 3);
  for (const std::uint64_t period_ns : {2'000'000U, 9'700'000U, 33'333'333U, 171'000'000U})
    for (const std::uint64_t round_trip_ns :
         {0U, 310'000U, 11'000'000U, 41'000'000U, 230'000'000U}) {
      SceneMessage message = scene.told.message();
      message.period_ns = period_ns;
      const RelayedScene relayed(message, round_trip_ns);
      const std::uint64_t declared_ns = relayed.view().header().period_ns;
      // What lost a packet comes a round trip later; and no hand is told of less than 33 ms.
      if (period_ns + round_trip_ns >= 33'333'333 && round_trip_ns <= period_ns)
        CHECK(declared_ns == period_ns + round_trip_ns);
      CHECK(declared_ns >= std::max<std::uint64_t>(period_ns, 33'333'333));
      CHECK(declared_ns <= std::max<std::uint64_t>(2 * period_ns, 33'333'333));
    }
}

}  // namespace stillgrid::scene_relay::shown_scene_test
