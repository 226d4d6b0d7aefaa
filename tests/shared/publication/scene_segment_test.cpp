#include "shared/publication/scene_segment.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

#include "shared/collision/grid_query.hpp"
#include "shared/collision/sphere_history.hpp"
#include "tests/shared/publication/small_scene.hpp"
#include "tests/shared/publication/tampering.hpp"

namespace stillgrid::publication::scene_segment_test {
namespace {

using Times = std::array<std::uint64_t, proto::kHistoryLength>;
constexpr auto kScene = proto::SegmentKind::kScene;

SceneView view_of(const TestSession& session) {
  auto reader = SegmentReader::open(session.name(), kScene, proto::kSceneLayoutHash);
  REQUIRE(reader);
  return SceneView(std::move(*reader));
}

constexpr collision::SweptBound kNearFirst{{0.0F, 0.0F, -0.25F}, 0.025F};

/// A snapshot as a reader of the scene copies it out.
struct Snapshot {
  proto::SnapshotHeader header{};
  std::vector<proto::SphereRecord> spheres;
  std::vector<std::uint32_t> near_first;  // visited for a probe at the first sphere
};

Snapshot read_snapshot(const SceneView& view) {
  Snapshot snapshot;
  const double_buffer::ReadResult result =
      double_buffer::read_latest(view.buffer(), [&](const std::uint64_t* payload) {
        snapshot = {double_buffer::load_struct<proto::SnapshotHeader>(payload), {}, {}};
        const collision::GridView grid = view.moving_grid(payload, snapshot.header);
        for (std::uint32_t i = 0; i < grid.shape.sphere_count; ++i)
          snapshot.spheres.push_back(collision::load_record(grid, i));
        collision::for_each_candidate(
            grid, kNearFirst, collision::kAllVisits,
            [&](std::uint32_t sphere) { snapshot.near_first.push_back(sphere); });
      });
  REQUIRE(result.status == double_buffer::ReadStatus::kAccepted);
  CHECK(result.snapshot_id == snapshot.header.snapshot_id);
  return snapshot;
}

/// The snapshot n that a record shows `age` snapshots back.
bool shows(const proto::SphereRecord& record, std::size_t i, std::size_t age, std::uint64_t n) {
  const auto p = SmallSceneWriter::position_m(i, n).cast<float>().eval();
  const auto v = SmallSceneWriter::velocity_m_s(i, n).cast<float>().eval();
  const proto::SphereState& snapshot = age == 0 ? record.newest : record.before;
  return snapshot.position_m == std::array{p.x(), p.y(), p.z()} &&
         snapshot.velocity_m_s == std::array{v.x(), v.y(), v.z()};
}

TEST_CASE("The fixed part is read as it was written", "[scene_segment]") {
  const TestSession session;
  const SmallSceneWriter writer(session);
  const SceneView view = view_of(session);
  const StaticScene scene = small_scene();
  const auto same = [](const auto& list, const auto& read) {
    return std::memcmp(list.data(), read.data(), list.size() * sizeof(list[0])) == 0;
  };

  CHECK(std::string(view.scene().name.data()) == "small");
  REQUIRE(view.scene().material_count == 2);
  REQUIRE(view.scene().plane_count == 1);
  REQUIRE(view.scene().tool_sphere_count == 2);
  CHECK(same(scene.materials, view.scene().materials));
  CHECK(same(scene.planes, view.scene().planes));
  CHECK(same(scene.tool, view.scene().tool));
  CHECK(std::memcmp(&view.scene().device, &scene.device, sizeof scene.device) == 0);
  CHECK(view.scene().moving_capacity == kMovingSpheres);
  CHECK(view.header().period_ns == kPeriod_ns);
}

TEST_CASE("Both sides find the same static spheres", "[scene_segment]") {
  const TestSession session;
  SmallSceneWriter writer(session);
  const SceneView view = view_of(session);
  const auto found_in = [](const collision::GridView& grid) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
    collision::for_each_candidate(
        grid, {{0.035F, 0.0F, -0.05F}, 0.015F}, collision::kAllVisits, [&](std::uint32_t sphere) {
          found.emplace_back(sphere, collision::load_record(grid, sphere).body);
        });
    return found;
  };

  CHECK(view.static_grid().shape.sphere_count == 10);
  CHECK(found_in(view.static_grid()).size() >= 4);
  CHECK(found_in(view.static_grid()) == found_in(writer.writer().static_grid()));

  std::vector<std::uint32_t> touched;
  const float probe_radius_m = view.touch_lists().probe_radius_m();
  CHECK(probe_radius_m == touch_probe_radius_m(0.005F));
  view.touch_lists().for_each_touch({{0.035F, 0.0F, -0.05F}, probe_radius_m}, collision::kAllVisits,
                                    [&](const collision::TouchEntry& entry) {
                                      touched.push_back(entry.label.number);
                                      CHECK(entry.label.body == 6);
                                      CHECK(entry.label.material == 1);
                                      CHECK(entry.radius_m == 0.008F);
                                    });
  CHECK(touched == std::vector<std::uint32_t>{2, 3, 4, 5});  // up to 15 mm off, within 18.6 mm
}

TEST_CASE("Before the first snapshot there is none to read", "[scene_segment]") {
  const TestSession session;
  const SmallSceneWriter writer(session);
  const SceneView view = view_of(session);
  CHECK(double_buffer::read_latest(view.buffer(), [](const std::uint64_t*) {}).status ==
        double_buffer::ReadStatus::kEmpty);
}

TEST_CASE("The first snapshot stands for the whole history", "[scene_segment]") {
  const TestSession session;
  SmallSceneWriter writer(session);
  const SceneView view = view_of(session);
  writer.publish_next();

  const Snapshot snapshot = read_snapshot(view);

  CHECK(snapshot.header.history_count == 1);
  CHECK(snapshot.header.state_time_ns == Times{kPeriod_ns, kPeriod_ns});
  REQUIRE(snapshot.spheres.size() == kMovingSpheres);
  for (std::size_t i = 0; i < kMovingSpheres; ++i)
    for (std::size_t age = 0; age < proto::kHistoryLength; ++age)
      CHECK(shows(snapshot.spheres[i], i, age, 1));
}

TEST_CASE("Each snapshot pushes the others one down the history", "[scene_segment]") {
  const TestSession session;
  SmallSceneWriter writer(session);
  const SceneView view = view_of(session);
  for (std::uint64_t n = 1; n <= 7; ++n) {
    writer.publish_next();
    const Snapshot snapshot = read_snapshot(view);
    const proto::SnapshotHeader& header = snapshot.header;

    CHECK(header.snapshot_id == n);
    CHECK(header.history_count == std::min<std::uint64_t>(n, proto::kHistoryLength));
    CHECK(header.tool_time_ns == n * kPeriod_ns - 9);
    CHECK(header.step_ns == 1000 + n);
    CHECK(header.contacts == n);
    CHECK(view.reader().live().heartbeat_ns == n * kPeriod_ns + 5);
    for (std::size_t age = 0; age < proto::kHistoryLength; ++age) {
      const std::uint64_t number = n > age ? n - age : 1;  // missing ones repeat the oldest
      CHECK(header.state_time_ns[age] == number * kPeriod_ns);
      CHECK(header.publish_time_ns[age] == number * kPeriod_ns + 5);
      for (std::size_t i = 0; i < kMovingSpheres; ++i)
        CHECK(shows(snapshot.spheres[i], i, age, number));
    }
    for (std::size_t i = 0; i < kMovingSpheres; ++i) {
      CHECK(snapshot.spheres[i].radius_m == 0.01F);
      CHECK(snapshot.spheres[i].material == 1);
      CHECK(snapshot.spheres[i].body == i);
    }
  }
}

TEST_CASE("A published grid finds what the writer's own finds", "[scene_segment]") {
  const TestSession session;
  SmallSceneWriter writer(session);
  const SceneView view = view_of(session);
  writer.publish_next();

  const Snapshot snapshot = read_snapshot(view);

  std::vector<std::uint32_t> expected;
  collision::for_each_candidate(writer.snapshot().view(), kNearFirst, collision::kAllVisits,
                                [&](std::uint32_t sphere) { expected.push_back(sphere); });
  CHECK(expected.size() == 2);  // 30 mm apart, of radius 10 mm
  CHECK(snapshot.near_first == expected);
}

TEST_CASE("A scene without moving or static spheres can be published too", "[scene_segment]") {
  const TestSession session;
  StaticScene scene = small_scene();
  scene.spheres.clear();
  SceneWriter writer(session.name(), scene, 0, kPeriod_ns, proto::Clock::kVirtual, 0);
  const SceneView view = view_of(session);
  writer.publish(collision::VoxelGrid(sizeof(proto::SnapshotHeader), 0), {.state_ns = kPeriod_ns});

  const Snapshot snapshot = read_snapshot(view);

  CHECK(snapshot.header.snapshot_id == 1);
  CHECK(snapshot.spheres.empty());
}

TEST_CASE("A snapshot whose grid lies is shown as empty", "[scene_segment]") {
  const TestSession session;
  SmallSceneWriter writer(session);
  const SceneView view = view_of(session);
  writer.publish_next();
  const Tampering memory(session.path(kScene));
  auto& grid = memory.at<proto::SnapshotHeader>(view.header().slot_offset[1] + 64).grid;
  REQUIRE(grid.sphere_count == kMovingSpheres);

  SECTION("spheres") {
    grid.sphere_count = kMovingSpheres + 1;
  }
  SECTION("levels") {
    grid.level_count = 0xFFFFFFFF;
  }
  SECTION("cells") {
    grid.levels[0].cells[1] = 0x80000000;
  }
  SECTION("voxel") {
    grid.levels[0].voxel_m = 0.0F;
  }

  CHECK(read_snapshot(view).spheres.empty());
}

}  // namespace
}  // namespace stillgrid::publication::scene_segment_test
