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
  CHECK(kSegmentVersion == 6);

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
  CHECK(offsetof(ToolState, before) == 128);
  CHECK(sizeof(ToolState) == 320);
  CHECK(offsetof(TickFigures, contacts) == 24);
  CHECK(offsetof(TickFigures, flags) == 28);
  CHECK(offsetof(TickFigures, work_ns) == 32);
  CHECK(offsetof(TickFigures, wake_up_latency_ns) == 40);
  CHECK(offsetof(TickFigures, missed_ticks) == 48);
  CHECK(offsetof(TickFigures, displayed) == 56);
  CHECK(sizeof(TickFigures) == 192);
  CHECK(offsetof(DisplayedSnapshot, snapshot_id) == 8);
  CHECK(offsetof(DisplayedSnapshot, position) == 16);
  CHECK(offsetof(DisplayedSnapshot, velocity_s) == 48);
  CHECK(offsetof(DisplayedSnapshot, prediction_s) == 72);
  CHECK(offsetof(DisplayedSnapshot, compliance_lag_s) == 80);
  CHECK(offsetof(DisplayedSnapshot, force_change_N) == 88);
  CHECK(offsetof(DisplayedSnapshot, shift_m) == 96);
  CHECK(offsetof(DisplayedSnapshot, alpha) == 120);
  CHECK(offsetof(DisplayedSnapshot, age_s) == 128);
  CHECK(sizeof(DisplayedSnapshot) == 136);

  CHECK(offsetof(SceneHeader, material_count) == 64);
  CHECK(offsetof(SceneHeader, tool_slip_speed_m_s) == 84);
  CHECK(offsetof(SceneHeader, static_offset) == 88);
  CHECK(offsetof(SceneHeader, device) == 96);
  CHECK(offsetof(SceneHeader, static_grid) == 160);
  CHECK(offsetof(SceneHeader, materials) == 552);
  CHECK(offsetof(SceneHeader, planes) == 1576);
  CHECK(offsetof(SceneHeader, tool) == 3112);
  CHECK(sizeof(SceneHeader) == 3368);

  CHECK(offsetof(SnapshotHeader, history_count) == 8);
  CHECK(offsetof(SnapshotHeader, state_time_ns) == 16);
  CHECK(offsetof(SnapshotHeader, publish_time_ns) == 48);
  CHECK(offsetof(SnapshotHeader, tool_time_ns) == 80);
  CHECK(offsetof(SnapshotHeader, step_ns) == 88);
  CHECK(offsetof(SnapshotHeader, contacts) == 96);
  CHECK(offsetof(SnapshotHeader, prediction_ns) == 104);
  CHECK(offsetof(SnapshotHeader, compliance_direction) == 112);
  CHECK(offsetof(SnapshotHeader, compliance_force_N) == 136);
  CHECK(offsetof(SnapshotHeader, max_compliance_m_per_N) == 144);
  CHECK(offsetof(SnapshotHeader, grid) == 152);
  CHECK(sizeof(SnapshotHeader) == 544);

  CHECK(offsetof(GridShape, sphere_count) == 0);
  CHECK(offsetof(GridShape, level_count) == 4);
  CHECK(offsetof(GridShape, levels) == 8);
  CHECK(sizeof(GridShape) == 392);
  CHECK(offsetof(GridLevel, lowest_voxel) == 0);
  CHECK(offsetof(GridLevel, voxel_m) == 12);
  CHECK(offsetof(GridLevel, highest_voxel) == 16);
  CHECK(offsetof(GridLevel, bounding_radius_m) == 28);
  CHECK(offsetof(GridLevel, cells) == 32);
  CHECK(offsetof(GridLevel, first_cell) == 44);
  CHECK(sizeof(GridLevel) == 48);
  CHECK(offsetof(SweptBound, bounding_radius_m) == 12);
  CHECK(sizeof(SweptBound) == 16);

  CHECK(sizeof(SphereState) == 24);
  CHECK(offsetof(SphereRecord, radius_m) == 48);
  CHECK(offsetof(SphereRecord, predicted_velocity_m_s) == 24);
  CHECK(offsetof(SphereRecord, compliance_m_per_N) == 36);
  CHECK(offsetof(SphereRecord, older) == 64);
  CHECK(offsetof(SphereRecord, oldest_position_m) == 112);
  CHECK(offsetof(SphereRecord, material) == 52);
  CHECK(offsetof(SphereRecord, body) == 56);
  CHECK(sizeof(SphereRecord) == 128);
}

TEST_CASE("A tool segment is one page with its slots at 448 and 832", "[layout]") {
  const TestSession session;
  ToolWriter writer(session.name(), 1'000'000, Clock::kVirtual, 0);

  CHECK(writer.header().size_bytes == 4096);
  CHECK(writer.header().slot_offset == std::array<std::uint64_t, 2>{448, 832});
  CHECK(writer.header().payload_bytes == 320);
}

TEST_CASE("A scene segment is its header, its static grid and two slots", "[layout]") {
  const TestSession session;
  SmallSceneWriter scene(session);
  const SegmentHeader& header = scene.writer().header();

  // Starts of 8 cells a sphere and 512 more, to a multiple of 64 bytes.
  const std::size_t static_bytes = 128 * 10 + 2432 + 16 * 13 + 4 * 10;
  const std::size_t payload_bytes = 576 + 128 * 7 + 2304 + 16 * 10 + (4 * 7 + 4);
  const std::size_t first_slot = (3840 + static_bytes + 63) / 64 * 64;
  CHECK(header.slot_offset[0] == first_slot);
  CHECK(header.slot_offset[1] == first_slot + 64 + (payload_bytes + 63) / 64 * 64);
  CHECK(header.payload_bytes == payload_bytes);
  CHECK(header.size_bytes % 4096 == 0);
}

TEST_CASE("100 moving spheres make a payload of 20736 bytes", "[layout]") {
  const GridLayout layout = grid_layout(sizeof(SnapshotHeader), 100);
  CHECK(layout.cell_capacity == 1312);
  CHECK(layout.records * 8 == 576);
  CHECK(layout.total_words * 8 == 20736);
}

}  // namespace
}  // namespace stillgrid
