// Of every scene that ships, what a relay shows is what its simulation publishes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <random>

#include "shared/reading/snapshot.hpp"
#include "shared/tools/scene_relay/snapshot_coding.hpp"
#include "sim_server/lockstep_simulation.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/network/relay/relayed_scene.hpp"
#include "tests/network/relay/shown_history.hpp"

namespace stillgrid::scene_relay::shipped_scenes_test {
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
    if (view.scene().hand_count > 1)
      CHECK(relayed.view().model().empty());  // no path of the other hand comes over
    else
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
        const double s = 1e-9 * static_cast<double>(now_ns);
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
      REQUIRE(history.wrong_in(now) == "");
      for (std::size_t i = 0; i < snapshot->spheres.size(); ++i)
        REQUIRE(are_same_bytes(now.records[i].newest, snapshot->spheres[i].newest));
    }
  }
}

}  // namespace stillgrid::scene_relay::shipped_scenes_test
