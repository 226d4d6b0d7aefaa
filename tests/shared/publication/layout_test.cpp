#include <catch2/catch.hpp>
#include <cstddef>

#include "proto/scene_segment.hpp"
#include "proto/tool_segment.hpp"
#include "shared/publication/segment.hpp"
#include "shared/publication/tool_segment.hpp"
#include "tests/shared/publication/small_scene.hpp"

namespace stillgrid {
namespace {

using namespace proto;

// A change here is a change of the protocol: raise kSegmentVersion and mend docs/protocol.md.
TEST_CASE("The layouts are those that docs/protocol.md draws", "[layout]") {
  CHECK(kSegmentVersion == 1);

  CHECK(offsetof(SegmentHeader, version) == 8);
  CHECK(offsetof(SegmentHeader, kind) == 12);
  CHECK(offsetof(SegmentHeader, layout_hash) == 16);
  CHECK(offsetof(SegmentHeader, epoch) == 24);
  CHECK(offsetof(SegmentHeader, size_bytes) == 32);
  CHECK(offsetof(SegmentHeader, period_ns) == 40);
  CHECK(offsetof(SegmentHeader, clock) == 48);
  CHECK(offsetof(SegmentHeader, writer_pid) == 52);
  CHECK(offsetof(SegmentHeader, start_ns) == 56);
  CHECK(offsetof(SegmentHeader, slot_offset) == 64);
  CHECK(offsetof(SegmentHeader, payload_bytes) == 80);
  CHECK(offsetof(SegmentHeader, latest) == 256);
  CHECK(offsetof(SegmentHeader, heartbeat_ns) == 320);
  CHECK(offsetof(SegmentHeader, lockstep_sample_ns) == 384);
  CHECK(offsetof(SegmentHeader, lockstep_event_ns) == 392);
  CHECK(sizeof(SegmentHeader) == 448);
  CHECK(sizeof(SlotHeader) == 64);

  CHECK(offsetof(ToolState, tick) == 8);
  CHECK(offsetof(ToolState, position_m) == 16);
  CHECK(offsetof(ToolState, orientation_xyzw) == 40);
  CHECK(offsetof(ToolState, velocity_m_s) == 72);
  CHECK(offsetof(ToolState, force_N) == 96);
  CHECK(offsetof(ToolState, buttons) == 120);
  CHECK(sizeof(ToolState) == 128);

  CHECK(offsetof(SceneHeader, material_count) == 64);
  CHECK(offsetof(SceneHeader, log2_cell_capacity) == 80);
  CHECK(offsetof(SceneHeader, static_offset) == 88);
  CHECK(offsetof(SceneHeader, device) == 96);
  CHECK(offsetof(SceneHeader, static_grid) == 160);
  CHECK(offsetof(SceneHeader, materials) == 192);
  CHECK(offsetof(SceneHeader, planes) == 1216);
  CHECK(offsetof(SceneHeader, tool) == 2752);
  CHECK(sizeof(SceneHeader) == 3008);

  CHECK(offsetof(SnapshotHeader, history_count) == 8);
  CHECK(offsetof(SnapshotHeader, state_time_ns) == 16);
  CHECK(offsetof(SnapshotHeader, publish_time_ns) == 48);
  CHECK(offsetof(SnapshotHeader, tool_time_ns) == 80);
  CHECK(offsetof(SnapshotHeader, step_ns) == 88);
  CHECK(offsetof(SnapshotHeader, contacts) == 96);
  CHECK(offsetof(SnapshotHeader, grid) == 104);
  CHECK(sizeof(SnapshotHeader) == 136);

  CHECK(offsetof(GridShape, log2_cells) == 4);
  CHECK(offsetof(GridShape, sphere_count) == 16);
  CHECK(offsetof(GridShape, entry_count) == 20);
  CHECK(offsetof(GridShape, long_count) == 24);
  CHECK(sizeof(GridShape) == 32);

  CHECK(sizeof(SphereImage) == 24);
  CHECK(offsetof(SphereRecord, radius_m) == 48);
  CHECK(offsetof(SphereRecord, lowest_voxel) == 52);
  CHECK(offsetof(SphereRecord, older) == 64);
  CHECK(offsetof(SphereRecord, material) == 112);
  CHECK(offsetof(SphereRecord, body) == 116);
  CHECK(sizeof(SphereRecord) == 128);
}

TEST_CASE("A tool segment is one page with its slots at 448 and 640", "[layout]") {
  const TestSession session;
  ToolWriter writer(session.name(), 1'000'000, Clock::kVirtual, 0);

  CHECK(writer.header().size_bytes == 4096);
  CHECK(writer.header().slot_offset == std::array<std::uint64_t, 2>{448, 640});
  CHECK(writer.header().payload_bytes == 128);
}

TEST_CASE("A scene segment is its header, its still grid and two slots", "[layout]") {
  const TestSession session;
  SmallSceneWriter scene(session);
  const SegmentHeader& header = scene.writer().header();

  // 10 still spheres in 64 cells, then 7 moving ones in 64 cells.
  const std::size_t still_bytes = 128 * 10 + (4 * 65 + 4) + 256 * 10 + 4 * 10;
  const std::size_t payload_bytes = 192 + 128 * 7 + (4 * 65 + 4) + 256 * 7 + (4 * 7 + 4);
  const std::size_t first_slot = (3456 + still_bytes + 63) / 64 * 64;
  CHECK(header.slot_offset[0] == first_slot);
  CHECK(header.slot_offset[1] == first_slot + 64 + (payload_bytes + 63) / 64 * 64);
  CHECK(header.payload_bytes == payload_bytes);
  CHECK(header.size_bytes % 4096 == 0);
}

TEST_CASE("100 moving spheres make a payload of 41048 bytes", "[layout]") {
  const GridLayout layout = grid_layout(sizeof(SnapshotHeader), 100, log2_cells_for(100));
  CHECK(layout.log2_cell_capacity == 9);
  CHECK(layout.records * 8 == 192);
  CHECK(layout.total_words * 8 == 41048);
}

}  // namespace
}  // namespace stillgrid
