#include <catch2/catch.hpp>
#include <cstddef>

#include "proto/scene_segment.hpp"
#include "proto/tool_segment.hpp"
#include "shared/publication/segment.hpp"
#include "shared/publication/tool_segment.hpp"
#include "tests/shared/publication/small_scene.hpp"

namespace stillgrid::publication {
namespace {

// A change here is a change of the protocol: raise kSegmentVersion and mend docs/protocol.md.
TEST_CASE("The layouts are those that docs/protocol.md draws", "[layout]") {
  CHECK(proto::kSegmentVersion == 10);

  CHECK(offsetof(proto::SegmentHeader, version) == 8);
  CHECK(offsetof(proto::SegmentHeader, kind) == 12);
  CHECK(offsetof(proto::SegmentHeader, layout_hash) == 16);
  CHECK(offsetof(proto::SegmentHeader, epoch) == 24);
  CHECK(offsetof(proto::SegmentHeader, size_bytes) == 32);
  CHECK(offsetof(proto::SegmentHeader, period_ns) == 40);
  CHECK(offsetof(proto::SegmentHeader, clock) == 48);
  CHECK(offsetof(proto::SegmentHeader, writer_pid) == 52);
  CHECK(offsetof(proto::SegmentHeader, start_ns) == 56);
  CHECK(offsetof(proto::SegmentHeader, slot_offset) == 64);
  CHECK(offsetof(proto::SegmentHeader, payload_bytes) == 80);
  CHECK(offsetof(proto::SegmentHeader, latest) == 256);
  CHECK(offsetof(proto::SegmentHeader, heartbeat_ns) == 320);
  CHECK(offsetof(proto::SegmentHeader, lockstep_sample_ns) == 384);
  CHECK(offsetof(proto::SegmentHeader, lockstep_event_ns) == 392);
  CHECK(sizeof(proto::SegmentHeader) == 448);
  CHECK(sizeof(proto::SlotHeader) == 64);

  CHECK(offsetof(proto::ToolState, tick) == 8);
  CHECK(offsetof(proto::ToolState, position_m) == 16);
  CHECK(offsetof(proto::ToolState, orientation_xyzw) == 40);
  CHECK(offsetof(proto::ToolState, velocity_m_s) == 72);
  CHECK(offsetof(proto::ToolState, force_N) == 96);
  CHECK(offsetof(proto::ToolState, buttons) == 120);
  CHECK(offsetof(proto::ToolState, before) == 128);
  CHECK(offsetof(proto::ToolState, device) == 512);
  CHECK(sizeof(proto::ToolState) == 576);
  CHECK(offsetof(proto::TickFigures, contacts) == 24);
  CHECK(offsetof(proto::TickFigures, flags) == 28);
  CHECK(offsetof(proto::TickFigures, work_ns) == 32);
  CHECK(offsetof(proto::TickFigures, wake_up_latency_ns) == 40);
  CHECK(offsetof(proto::TickFigures, missed_ticks) == 48);
  CHECK(offsetof(proto::TickFigures, displayed) == 56);
  CHECK(sizeof(proto::TickFigures) == 384);
  CHECK(offsetof(proto::DisplayedSnapshot, snapshot_id) == 8);
  CHECK(offsetof(proto::DisplayedSnapshot, position) == 16);
  CHECK(offsetof(proto::DisplayedSnapshot, velocity_s) == 48);
  CHECK(offsetof(proto::DisplayedSnapshot, prediction_s) == 72);
  CHECK(offsetof(proto::DisplayedSnapshot, compliance_lag_s) == 80);
  CHECK(offsetof(proto::DisplayedSnapshot, modes) == 88);
  CHECK(offsetof(proto::DisplayedSnapshot, shifts) == 184);
  CHECK(offsetof(proto::DisplayedSnapshot, alpha) == 312);
  CHECK(offsetof(proto::DisplayedSnapshot, age_s) == 320);
  CHECK(sizeof(proto::DisplayedSnapshot) == 328);
  CHECK(sizeof(proto::BodyShift) == 32);

  CHECK(offsetof(proto::SceneHeader, material_count) == 64);
  CHECK(offsetof(proto::SceneHeader, tool_slip_speed_m_s) == 84);
  CHECK(offsetof(proto::SceneHeader, static_offset) == 88);
  CHECK(offsetof(proto::SceneHeader, device) == 96);
  CHECK(offsetof(proto::SceneHeader, static_grid) == 160);
  CHECK(offsetof(proto::SceneHeader, materials) == 552);
  CHECK(offsetof(proto::SceneHeader, planes) == 1576);
  CHECK(offsetof(proto::SceneHeader, tool) == 3112);
  CHECK(offsetof(proto::SceneHeader, touch_lists) == 3368);
  CHECK(sizeof(proto::SceneHeader) == 3776);
  CHECK(offsetof(proto::TouchShape, cell_count) == 8);
  CHECK(offsetof(proto::TouchShape, entry_count) == 12);
  CHECK(offsetof(proto::TouchShape, probe_radius_m) == 16);
  CHECK(offsetof(proto::TouchShape, level_count) == 20);
  CHECK(offsetof(proto::TouchShape, levels) == 24);
  CHECK(sizeof(proto::TouchShape) == 408);
  CHECK(offsetof(proto::TouchLabel, material) == 4);
  CHECK(offsetof(proto::TouchLabel, body) == 8);
  CHECK(sizeof(proto::TouchLabel) == 16);

  CHECK(offsetof(proto::SnapshotHeader, history_count) == 8);
  CHECK(offsetof(proto::SnapshotHeader, state_time_ns) == 16);
  CHECK(offsetof(proto::SnapshotHeader, publish_time_ns) == 48);
  CHECK(offsetof(proto::SnapshotHeader, tool_time_ns) == 80);
  CHECK(offsetof(proto::SnapshotHeader, tool_work_J) == 88);
  CHECK(offsetof(proto::SnapshotHeader, step_ns) == 96);
  CHECK(offsetof(proto::SnapshotHeader, contacts) == 104);
  CHECK(offsetof(proto::SnapshotHeader, prediction_ns) == 112);
  CHECK(offsetof(proto::SnapshotHeader, mode_count) == 120);
  CHECK(offsetof(proto::SnapshotHeader, response_count) == 124);
  CHECK(offsetof(proto::SnapshotHeader, turning_count) == 128);
  CHECK(offsetof(proto::SnapshotHeader, modes) == 136);
  CHECK(offsetof(proto::SnapshotHeader, turning) == 376);
  CHECK(offsetof(proto::SnapshotHeader, largest_response) == 1080);
  CHECK(offsetof(proto::SnapshotHeader, grid) == 1088);
  CHECK(sizeof(proto::SnapshotHeader) == 1480);
  CHECK(sizeof(proto::ResponseMode) == 20);
  CHECK(offsetof(proto::TurningBody, centre_m) == 4);
  CHECK(offsetof(proto::TurningBody, velocity_m_s) == 16);
  CHECK(offsetof(proto::TurningBody, turns) == 28);
  CHECK(sizeof(proto::TurningBody) == 176);
  CHECK(sizeof(proto::SphereResponse) == 144);

  CHECK(offsetof(proto::GridShape, sphere_count) == 0);
  CHECK(offsetof(proto::GridShape, level_count) == 4);
  CHECK(offsetof(proto::GridShape, levels) == 8);
  CHECK(sizeof(proto::GridShape) == 392);
  CHECK(offsetof(proto::GridLevel, lowest_voxel) == 0);
  CHECK(offsetof(proto::GridLevel, voxel_m) == 12);
  CHECK(offsetof(proto::GridLevel, highest_voxel) == 16);
  CHECK(offsetof(proto::GridLevel, bounding_radius_m) == 28);
  CHECK(offsetof(proto::GridLevel, cells) == 32);
  CHECK(offsetof(proto::GridLevel, first_cell) == 44);
  CHECK(sizeof(proto::GridLevel) == 48);
  CHECK(offsetof(collision::SweptBound, bounding_radius_m) == 12);
  CHECK(sizeof(collision::SweptBound) == 16);

  CHECK(sizeof(proto::SphereState) == 24);
  CHECK(offsetof(proto::SphereRecord, radius_m) == 36);
  CHECK(offsetof(proto::SphereRecord, predicted_velocity_m_s) == 24);
  CHECK(offsetof(proto::SphereRecord, response) == 48);
  CHECK(offsetof(proto::SphereRecord, older) == 64);
  CHECK(offsetof(proto::SphereRecord, oldest_position_m) == 112);
  CHECK(offsetof(proto::SphereRecord, material) == 40);
  CHECK(offsetof(proto::SphereRecord, body) == 44);
  CHECK(sizeof(proto::SphereRecord) == 128);
}

TEST_CASE("A tool segment is one page with its slots at 448 and 1088", "[layout]") {
  const TestSession session;
  ToolWriter writer(session.name(), 1'000'000, proto::Clock::kVirtual, 0);

  CHECK(writer.header().size_bytes == 4096);
  CHECK(writer.header().slot_offset == std::array<std::uint64_t, 2>{448, 1088});
  CHECK(writer.header().payload_bytes == 576);
}

TEST_CASE("A scene segment is its header, its static spheres twice and two slots", "[layout]") {
  const TestSession session;
  SmallSceneWriter scene(session);
  const proto::SegmentHeader& header = scene.writer().header();

  // Starts of 8 cells a sphere and 512 more, to a multiple of 64 bytes.
  const std::size_t static_bytes = 128 * 10 + 2432 + 16 * 13 + 4 * 10;
  const std::size_t grid_bytes = 1536 + 128 * 7 + 2304 + 16 * 10 + (4 * 7 + 4);
  const std::size_t payload_bytes = (grid_bytes + 63) / 64 * 64 + 144 * 7;
  const proto::TouchShape& lists = scene.writer().scene().touch_lists;
  CHECK(lists.offset == (4224 + static_bytes + 63) / 64 * 64);
  const std::size_t list_bytes =
      (std::size_t{lists.cell_count} * 4 + 4 + 63) / 64 * 64 + std::size_t{lists.entry_count} * 32;
  const std::size_t first_slot = (lists.offset + list_bytes + 63) / 64 * 64;
  CHECK(header.slot_offset[0] == first_slot);
  CHECK(header.slot_offset[1] == first_slot + 64 + (payload_bytes + 63) / 64 * 64);
  CHECK(header.payload_bytes == payload_bytes);
  CHECK(header.size_bytes % 4096 == 0);
}

TEST_CASE("100 moving spheres make a payload of 21696 bytes", "[layout]") {
  const collision::GridLayout layout = collision::grid_layout(sizeof(proto::SnapshotHeader), 100);
  CHECK(layout.cell_capacity == 1312);
  CHECK(layout.records * 8 == 1536);
  CHECK(layout.total_words * 8 == 21696);
}

}  // namespace
}  // namespace stillgrid::publication
