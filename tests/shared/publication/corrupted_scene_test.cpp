#include <catch2/catch.hpp>
#include <cmath>

#include "tests/shared/publication/small_scene.hpp"
#include "tests/shared/publication/tampering.hpp"

namespace stillgrid::publication::corrupted_scene_test {
namespace {

constexpr auto kScene = proto::SegmentKind::kScene;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// What a reader says of a scene segment whose fixed part was spoilt after its writer wrote it.
template <class Spoil>
std::string refusal_when(Spoil&& spoil) {
  const TestSession session;
  SmallSceneWriter writer(session);
  writer.publish_next();
  const Tampering memory(session.path(kScene));
  spoil(memory.at<proto::SceneHeader>(sizeof(proto::SegmentHeader)), writer.writer().header());
  return refusal_of([&] {
    auto reader = SegmentReader::open(session.name(), kScene, proto::kSceneLayoutHash);
    if (reader) const SceneView view(std::move(*reader));
  });
}

template <class Spoil>
bool is_refused(Spoil&& spoil) {
  return !refusal_when([&](proto::SceneHeader& scene, auto&) { spoil(scene); }).empty();
}

TEST_CASE("A sound fixed part is accepted", "[corrupted_scene]") {
  CHECK_FALSE(is_refused([](auto&) {}));
}

TEST_CASE("A fixed part with a count out of range is refused", "[corrupted_scene]") {
  CHECK(is_refused([](auto& scene) { scene.material_count = proto::kMaxMaterials + 1; }));
  CHECK(is_refused([](auto& scene) { scene.plane_count = proto::kMaxPlanes + 1; }));
  CHECK(is_refused([](auto& scene) { scene.tool_sphere_count = proto::kMaxToolSpheres + 1; }));
  CHECK(is_refused([](auto& scene) { scene.tool_sphere_count = 0; }));
  CHECK(is_refused([](auto& scene) { scene.name.fill('x'); }));
  CHECK(is_refused([](auto& scene) { scene.planes[0].material = scene.material_count; }));
}

TEST_CASE("A fixed part with a number that is none is refused", "[corrupted_scene]") {
  for (const float bad : {kNaN, INFINITY, -INFINITY}) {
    CHECK(is_refused([&](auto& scene) { scene.materials[1].stiffness_N_per_m = bad; }));
    CHECK(is_refused([&](auto& scene) { scene.materials[1].damping_N_s_per_m = bad; }));
    CHECK(is_refused([&](auto& scene) { scene.materials[1].friction = bad; }));
    CHECK(is_refused([&](auto& scene) { scene.materials[1].slip_speed_m_s = bad; }));
    CHECK(is_refused([&](auto& scene) { scene.planes[0].offset_m = bad; }));
    CHECK(is_refused([&](auto& scene) { scene.planes[0].normal[1] = bad; }));
    CHECK(is_refused([&](auto& scene) { scene.tool[1].position_m[2] = bad; }));
    CHECK(is_refused([&](auto& scene) { scene.tool[1].radius_m = bad; }));
    const double bad_too = double{bad};
    CHECK(is_refused([&](auto& scene) { scene.device.position_m[0] = bad_too; }));
    CHECK(is_refused([&](auto& scene) { scene.device.orientation_xyzw[0] = bad_too; }));
    CHECK(is_refused([&](auto& scene) { scene.device.scale = bad_too; }));
  }
}

TEST_CASE("A fixed part with an impossible number is refused", "[corrupted_scene]") {
  CHECK(is_refused([](auto& scene) { scene.materials[0].stiffness_N_per_m = -1.0F; }));
  CHECK(is_refused([](auto& scene) { scene.materials[0].damping_N_s_per_m = -1.0F; }));
  CHECK(is_refused([](auto& scene) { scene.materials[0].friction = -0.1F; }));
  CHECK(is_refused([](auto& scene) { scene.materials[0].slip_speed_m_s = 0.0F; }));
  CHECK(is_refused([](auto& scene) { scene.planes[0].normal = {0.0F, 0.0F, 1.1F}; }));
  CHECK(is_refused([](auto& scene) { scene.tool[0].radius_m = 0.0F; }));
  CHECK(is_refused([](auto& scene) { scene.device.scale = 0.0; }));
  CHECK(is_refused([](auto& scene) { scene.device.orientation_xyzw = {0, 0, 0, 0}; }));
}

TEST_CASE("A device's frame out of all proportion is refused", "[corrupted_scene]") {
  CHECK_FALSE(is_refused([](auto& scene) { scene.device.scale = proto::kLargestNumber; }));
  CHECK(is_refused([](auto& scene) { scene.device.scale = 1.1 * proto::kLargestNumber; }));
  CHECK(is_refused([](auto& scene) { scene.device.position_m[1] = 1e308; }));
  CHECK(is_refused([](auto& scene) { scene.device.position_m[2] = -1e308; }));
}

TEST_CASE("A device's turn that is nearly a unit quaternion is made one", "[corrupted_scene]") {
  const TestSession session;
  SmallSceneWriter writer(session);
  const Tampering memory(session.path(kScene));
  auto& scene = memory.at<proto::SceneHeader>(sizeof(proto::SegmentHeader));
  scene.device.orientation_xyzw = {0.0, 0.0, 0.6002, 0.8002};

  const SceneView view(*SegmentReader::open(session.name(), kScene, proto::kSceneLayoutHash));

  const auto& [x, y, z, w] = view.scene().device.orientation_xyzw;
  CHECK(x * x + y * y + z * z + w * w == Approx(1.0).epsilon(1e-14));
  CHECK(z / w == Approx(0.6002 / 0.8002).epsilon(1e-14));
}

TEST_CASE("A fixed part that leads outside the segment is refused", "[corrupted_scene]") {
  CHECK(is_refused([](auto& scene) { scene.static_offset += 64; }));
  CHECK(is_refused([](auto& scene) { scene.static_offset = UINT64_MAX - 63; }));
  CHECK(is_refused([](auto& scene) { scene.moving_capacity = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.hand_count = proto::kMaxHands + 1; }));
  CHECK(is_refused([](auto& scene) { scene.hand = 1; }));
  const auto is_name_refused = [&](std::string_view name) {
    return is_refused([&](auto& scene) {
      scene.hand_count = 2;
      scene.hands = {{{'a'}, {}}};
      name.copy(scene.hands[1].data(), proto::kHandNameBytes);
    });
  };
  CHECK_FALSE(is_name_refused("b"));
  for (const char* name : {"", "../b", "a+b", "a name of 17 chars", "0123456789012345678901234567"})
    CHECK(is_name_refused(name));
  CHECK(is_refused([](auto& scene) { scene.moving_capacity *= 2; }));
  CHECK(is_refused([](auto& scene) { scene.static_grid.sphere_count = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.static_grid.sphere_count += 10; }));
  CHECK(is_refused([](auto& scene) { scene.static_grid.level_count = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.static_grid.levels[0].cells[0] = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.static_grid.levels[0].first_cell = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.static_grid.levels[0].voxel_m = kNaN; }));
}

TEST_CASE("Touch lists that lead outside the segment are refused", "[corrupted_scene]") {
  CHECK(is_refused([](auto& scene) { scene.touch_lists.offset += 64; }));
  CHECK(is_refused([](auto& scene) { scene.touch_lists.offset = UINT64_MAX - 63; }));
  CHECK(is_refused([](auto& scene) { scene.touch_lists.cell_count = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.touch_lists.entry_count = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.touch_lists.entry_count += 4096; }));
  CHECK(is_refused([](auto& scene) { scene.touch_lists.probe_radius_m = kNaN; }));
  CHECK(is_refused([](auto& scene) { scene.touch_lists.level_count = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.touch_lists.levels[0].cells[0] = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.touch_lists.levels[0].first_cell = 0xFFFFFFFF; }));
  CHECK(is_refused([](auto& scene) { scene.touch_lists.levels[0].voxel_m = kNaN; }));
}

TEST_CASE("A first slot that overlaps the fixed part is refused", "[corrupted_scene]") {
  CHECK(refusal_when([](auto&, proto::SegmentHeader& header) {
          header.slot_offset[0] = sizeof(proto::SegmentHeader);
        }).find("fixed part is too short") != std::string::npos);
}

}  // namespace
}  // namespace stillgrid::publication::corrupted_scene_test
