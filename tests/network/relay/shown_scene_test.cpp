#include "shared/tools/scene_relay/shown_scene.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include "shared/reading/snapshot.hpp"
#include "shared/tools/scene_relay/snapshot_coding.hpp"
#include "sim_server/lockstep_simulation.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/network/relay/generated_snapshots.hpp"
#include "tests/network/relay/relayed_scene.hpp"
#include "tests/network/relay/shown_history.hpp"
#include "tests/shared/publication/field_scene.hpp"

namespace stillgrid::scene_relay::shown_scene_test {
namespace {

constexpr std::uint64_t kRelay = 0xBEE;

std::vector<std::filesystem::path> shipped_scenes() {
  std::vector<std::filesystem::path> scenes;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(STILLGRID_SOURCE_DIR) / "sim_server/scene/scenes"))
    if (entry.path().extension() == ".toml") scenes.push_back(entry.path());
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

sim_server::LockstepSimulation simulation_of(const scene::SceneDescription& scene) {
  return {scene, scene::build_world(scene),
          sim_server::LockstepSchedule(scene.period_s, 0.0, 1, 0.0)};
}

/// Where the first byte differs of what two writers wrote once; the size where none does. But for
/// the device's turn, which each reader makes a unit.
std::size_t first_difference(const publication::SceneView& a, const publication::SceneView& b) {
  if (a.reader().fixed_bytes() != b.reader().fixed_bytes()) return 0;
  const std::size_t turn =
      sizeof(proto::SegmentHeader) + offsetof(proto::SceneHeader, device.orientation_xyzw);
  for (std::size_t i = sizeof(proto::SegmentHeader); i < a.reader().fixed_bytes(); ++i) {
    const bool is_turn = i >= turn && i < turn + sizeof(proto::DeviceFrame::orientation_xyzw);
    if (!is_turn && a.reader().bytes()[i] != b.reader().bytes()[i]) return i;
  }
  return a.reader().fixed_bytes();
}

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

TEST_CASE("A scene that ships is shown to the byte as its simulation publishes it",
          "[shown_scene]") {
  for (const auto& path : shipped_scenes()) {
    const scene::SceneDescription description = scene::load_scene(path);
    const sim_server::LockstepSimulation simulation = simulation_of(description);
    const publication::SceneView view = simulation.view();
    const ToldScene told(view, kRelay);
    const RelayedScene relayed(told.message());
    INFO(path.filename());
    CHECK(first_difference(view, relayed.view()) == view.reader().fixed_bytes());
    CHECK(relayed.view().header().period_ns >= view.header().period_ns);
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(relayed.view().scene().device.orientation_xyzw[i] ==
            Approx(view.scene().device.orientation_xyzw[i]).margin(1e-15));
  }
}

TEST_CASE("Of a scene that ships the hand sees the snapshots that came, whatever was lost",
          "[shown_scene]") {
  const auto seed = GENERATE(5U, 6U);
  std::size_t responses = 0;
  for (const auto& path : shipped_scenes()) {
    const scene::SceneDescription description = scene::load_scene(path);
    const scene::Hand hand = scene::hands_of(description).front();
    sim_server::LockstepSimulation simulation = simulation_of(description);
    const publication::SceneView view = simulation.view();
    const ToldScene scene(view, kRelay);
    RelayedScene relayed(scene.message());
    SnapshotEncoder encoder(kRelay);
    SnapshotDecoder decoder;
    ShownHistory history;
    std::mt19937 random(seed);
    INFO(path.filename());
    for (int n = 0; n < 29; ++n) {
      const auto now_ns = static_cast<std::uint64_t>(1e9 * description.period_s * n) + 17;
      simulation.run_to(now_ns, false, [&]() -> std::optional<dynamics::ToolSample> {
        // Steps longer than a tick publish responses: there the hand reaches the scene in time.
        const double s =
            description.period_s > 0.001 ? 0.05 * n : 1e-9 * static_cast<double>(now_ns);
        const Eigen::Vector3d sway_m(0.011 * std::sin(7.0 * s), 0.007 * std::cos(5.0 * s),
                                     -0.03 * s);
        return dynamics::ToolSample{now_ns, hand.device.position_m + sway_m,
                                    Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()};
      });
      const auto snapshot = reading::read_snapshot(view, kMaxSpheres);
      REQUIRE(snapshot);
      const SnapshotMessage& message =
          encoder.encode(told(*snapshot, 0), scene.message().scene_epoch);
      if (n > 0 && std::bernoulli_distribution(0.27)(random)) continue;
      ToldSnapshot came;
      if (decoder.decode(message, relayed.shown().limits(), came) != Decoded::kSnapshot) continue;
      encoder.acknowledge(scene.message().scene_epoch, decoder.keyframe_id());
      history.take(came);
      relayed.shown().show(came, {.state_ns = now_ns, .publish_ns = now_ns + 7});
      const SeenSnapshot now = seen(relayed.view());
      REQUIRE(history.wrong_in(now, description.period_s) == "");
      for (std::size_t i = 0; i < snapshot->spheres.size(); ++i)
        REQUIRE(are_same_bytes(now.records[i].newest, snapshot->spheres[i].newest));
      REQUIRE(now.header.largest_response == snapshot->header.largest_response);
      responses += now.responses.size();
    }
  }
  CHECK(responses > 0);
}

TEST_CASE("Spheres that come, go and change begin their history anew, lost snapshots are in none",
          "[shown_scene]") {
  const auto seed = GENERATE(range(1U, 6U));
  const Going going = GENERATE(from_range(std::begin(kGoings), std::end(kGoings)));
  std::mt19937 random(19 * seed);
  const std::uint32_t spheres = 30 + 43 * seed;
  const Told scene(publication::field_scene(), spheres);
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
    REQUIRE(history.wrong_in(now, 33'333'333e-9) == "");
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
  fixed.predicts = GENERATE(false, true);
  fixed.name = std::string(GENERATE(0U, 1U, 62U, 63U), 'q');
  fixed.fields[1].body.rest = {
      {0.1F, 0.2F, 0.3F}, {0.0F, 0.6F, 0.0F, 0.8F}, {0.4F, 0.0F, 0.1F}, {0.0F, 0.7F, 0.0F}, 0.0F};
  const Told scene(fixed, 11);
  REQUIRE(scene.told.message().fields._length == 2);
  const RelayedScene relayed(scene.told.message());
  CHECK(first_difference(scene.view, relayed.view()) == scene.view.reader().fixed_bytes());
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
