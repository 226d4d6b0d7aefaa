#include "haptic_server/recording/scene_sampler.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "tests/shared/collision/sphere_state.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::recording::scene_sampler_test {
namespace {

constexpr std::uint64_t kPeriod_ns = 10'000'000;

/// A scene of so many spheres in a row that move by 1 mm a snapshot, and so many that do not.
class RowScene {
 public:
  RowScene(const std::string& session, std::size_t moving, std::size_t fixed)
      : snapshot_(sizeof(proto::SnapshotHeader), moving),
        writer_(session, scene_of(fixed), moving, kPeriod_ns, proto::Clock::kVirtual, 0) {
    for (std::uint32_t i = 0; i < moving; ++i) {
      snapshot_.records()[i].radius_m = 0.01F;
      snapshot_.records()[i].body = i % 2;
    }
  }

  void publish(int n, bool is_broken = false) {
    std::vector<proto::SphereState> states;
    for (std::size_t i = 0; i < snapshot_.records().size(); ++i)
      states.push_back(collision::sphere_state({0.001 * static_cast<double>(i), 0.001 * n, 0.0}));
    snapshot_.push_snapshot(states);
    snapshot_.enter(collision::history_bounds(snapshot_.records()), 1.0F);
    if (is_broken)
      snapshot_.records()[0].newest.position_m[1] = std::numeric_limits<float>::quiet_NaN();
    writer_.publish(snapshot_, {.publish_ns = kPeriod_ns * ++published_});
  }

 private:
  static publication::StaticScene scene_of(std::size_t fixed) {
    publication::StaticScene scene;
    scene.name = "row";
    scene.materials = {{500.0F, 1.0F, 0.2F, 1e-3F}};
    scene.tool = {{{0.0F, 0.0F, 0.0F}, 0.005F}};
    scene.device = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}, 1.0};
    for (std::size_t i = 0; i < fixed; ++i)
      scene.spheres.push_back(
          collision::static_sphere({0.002F * static_cast<float>(i), -1.0F, 0.0F}, 0.001F));
    return scene;
  }

  collision::VoxelGrid snapshot_;
  publication::SceneWriter writer_;
  std::uint64_t published_ = 0;
};

publication::SceneView view_of(const publication::TestSession& session) {
  auto reader = publication::SegmentReader::open(session.name(), proto::SegmentKind::kScene,
                                                 proto::kSceneLayoutHash);
  REQUIRE(reader);
  return publication::SceneView(std::move(*reader));
}

TEST_CASE("Each snapshot that shows something else is taken, once", "[scene_sampler]") {
  const publication::TestSession session;
  RowScene scene(session.name(), 7, 3);
  const publication::SceneView view = view_of(session);
  SceneSampler sampler;
  CHECK_FALSE(sampler.sample(view));
  for (const int n : {1, 2, 2, 3}) {
    static int last = 0;
    scene.publish(n);
    const auto sample = sampler.sample(view);
    CAPTURE(n);
    REQUIRE(sample.has_value() == (n != std::exchange(last, n)));
    CHECK_FALSE(sampler.sample(view));
    if (!sample) continue;
    REQUIRE(sample->moving.spheres.size() == 7);
    CHECK(sample->moving.spheres[2] ==
          SampledSphere{{0.002F, 0.001F * static_cast<float>(n), 0.0F}, 0.01F, 0});
    CHECK(sample->moving.spheres[3].body == 1);
    CHECK(sample->moving.left_out == 0);
    REQUIRE(sample->fixed.has_value() == (n == 1));
    if (n == 1) CHECK(sample->fixed->spheres.spheres.size() == 3);
    if (n == 1) CHECK(sample->fixed->tool.size() == 1);
  }
}

TEST_CASE("No more spheres a second are taken than a recording bears, whatever the scene",
          "[scene_sampler]") {
  const auto count = GENERATE(std::size_t{50}, 1000, 9000);
  const publication::TestSession session;
  RowScene scene(session.name(), count, 0);
  const publication::SceneView view = view_of(session);
  SceneSampler sampler;
  std::uint64_t taken = 0, samples = 0;
  constexpr int kSnapshots = 100;  // in a second
  for (int n = 1; n <= kSnapshots; ++n) {
    scene.publish(n);
    if (const auto sample = sampler.sample(view)) {
      taken += sample->moving.spheres.size();
      ++samples;
    }
  }
  CHECK(taken <= SceneSampler::kMaxSpheresPerSecond + count);
  CHECK(samples == std::min<std::uint64_t>(kSnapshots, (taken + count - 1) / count));
  CHECK((samples == kSnapshots || taken > SceneSampler::kMaxSpheresPerSecond * 8 / 10));
}

TEST_CASE("Of a scene too large for a message every second sphere is taken, or fewer",
          "[scene_sampler]") {
  const auto fixed = GENERATE(std::size_t{20'000}, 20'001, 45'000);
  const publication::TestSession session;
  RowScene scene(session.name(), 2, fixed);
  scene.publish(1);
  SceneSampler sampler;
  const auto sample = sampler.sample(view_of(session));
  REQUIRE(sample);
  const SampledSpheres& shown = sample->fixed->spheres;
  CHECK(shown.spheres.size() <= SceneSampler::kMaxSpheres);
  CHECK(shown.spheres.size() >= SceneSampler::kMaxSpheres / 2);
  CHECK(shown.spheres.size() + shown.left_out == fixed);
}

TEST_CASE("A sphere that is nowhere is left out and counted", "[scene_sampler]") {
  const publication::TestSession session;
  RowScene scene(session.name(), 5, 0);
  scene.publish(1, true);
  SceneSampler sampler;
  const auto sample = sampler.sample(view_of(session));
  REQUIRE(sample);
  CHECK(sample->moving.spheres.size() == 4);
  CHECK(sample->moving.left_out == 1);
}

TEST_CASE("Another scene under the same name is taken anew", "[scene_sampler]") {
  const publication::TestSession session;
  SceneSampler sampler;
  for (int run = 0; run < 2; ++run) {
    RowScene scene(session.name(), 3, 1);
    scene.publish(1);
    const auto sample = sampler.sample(view_of(session));
    REQUIRE(sample);
    CHECK(sample->fixed.has_value());
  }
}

}  // namespace
}  // namespace stillgrid::recording::scene_sampler_test
