#include <catch2/catch.hpp>
#include <cstddef>

#include "proto/mouse_segment.hpp"
#include "proto/scene_segment.hpp"
#include "proto/tool_segment.hpp"
#include "shared/publication/segment.hpp"
#include "shared/publication/tool_segment.hpp"
#include "tests/shared/publication/field_scene.hpp"
#include "tests/shared/publication/small_scene.hpp"

namespace stillgrid::publication::layout_test {
namespace {

// A change here is a change of the protocol: raise kSegmentVersion and mend docs/protocol.md.
TEST_CASE("The layouts are those that docs/protocol.md draws", "[layout]") {
  CHECK(proto::kSegmentVersion == 15);

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
  CHECK(offsetof(proto::SegmentHeader, relay) == 128);
  CHECK(offsetof(proto::SegmentHeader, latest) == 256);
  CHECK(offsetof(proto::SegmentHeader, heartbeat_ns) == 320);
  CHECK(offsetof(proto::SegmentHeader, lockstep_sample_ns) == 384);
  CHECK(offsetof(proto::SegmentHeader, lockstep_event_ns) == 392);
  CHECK(sizeof(proto::SegmentHeader) == 448);
  CHECK(sizeof(proto::SlotHeader) == 64);

  CHECK(offsetof(proto::RelayFigures, connected) == 8);
  CHECK(offsetof(proto::RelayFigures, clock_offset_ns) == 16);
  CHECK(offsetof(proto::RelayFigures, clock_bound_ns) == 24);
  CHECK(offsetof(proto::RelayFigures, round_trip_ns) == 32);
  CHECK(offsetof(proto::RelayFigures, received) == 40);
  CHECK(offsetof(proto::RelayFigures, received_bytes) == 48);
  CHECK(offsetof(proto::RelayFigures, lost) == 56);
  CHECK(offsetof(proto::RelayFigures, repeated) == 64);
  CHECK(offsetof(proto::RelayFigures, out_of_order) == 72);
  CHECK(offsetof(proto::RelayFigures, late) == 80);
  CHECK(offsetof(proto::RelayFigures, refused) == 88);
  CHECK(offsetof(proto::RelayFigures, partitions) == 96);
  CHECK(offsetof(proto::RelayFigures, longest_silence_ns) == 104);
  CHECK(offsetof(proto::RelayFigures, reserved) == 112);
  CHECK(sizeof(proto::RelayFigures) == 128);

  CHECK(offsetof(proto::MousePose, position_m) == 8);
  CHECK(offsetof(proto::MousePose, orientation_xyzw) == 32);
  CHECK(offsetof(proto::MousePose, buttons) == 64);
  CHECK(sizeof(proto::MousePose) == 72);

  CHECK(offsetof(proto::ToolState, tick) == 8);
  CHECK(offsetof(proto::ToolState, path_number) == 16);
  CHECK(offsetof(proto::ToolState, position_m) == 24);
  CHECK(offsetof(proto::ToolState, orientation_xyzw) == 48);
  CHECK(offsetof(proto::ToolState, velocity_m_s) == 80);
  CHECK(offsetof(proto::ToolState, force_N) == 104);
  CHECK(offsetof(proto::ToolState, buttons) == 128);
  CHECK(offsetof(proto::ToolState, before) == 136);
  CHECK(offsetof(proto::ToolState, device) == 232);
  CHECK(sizeof(proto::ToolState) == 296);

  CHECK(offsetof(proto::PathSample, position_m) == 8);
  CHECK(offsetof(proto::PathSample, orientation_xyzw) == 32);
  CHECK(offsetof(proto::PathSample, velocity_m_s) == 64);
  CHECK(sizeof(proto::PathSample) == 88);
  CHECK(offsetof(proto::ToolPath, samples) == 8);
  CHECK(sizeof(proto::ToolPath) == 360456);
  CHECK(offsetof(proto::TickFigures, contacts) == 24);
  CHECK(offsetof(proto::TickFigures, flags) == 28);
  CHECK(offsetof(proto::TickFigures, work_ns) == 32);
  CHECK(offsetof(proto::TickFigures, wake_up_latency_ns) == 40);
  CHECK(offsetof(proto::TickFigures, missed_ticks) == 48);
  CHECK(offsetof(proto::TickFigures, displayed) == 56);
  CHECK(sizeof(proto::TickFigures) == 96);
  CHECK(offsetof(proto::DisplayedSnapshot, snapshot_id) == 8);
  CHECK(offsetof(proto::DisplayedSnapshot, alpha) == 16);
  CHECK(offsetof(proto::DisplayedSnapshot, age_s) == 24);
  CHECK(offsetof(proto::DisplayedSnapshot, local_ticks) == 32);
  CHECK(offsetof(proto::DisplayedSnapshot, is_local) == 36);
  CHECK(sizeof(proto::DisplayedSnapshot) == 40);

  CHECK(offsetof(proto::SceneHeader, material_count) == 64);
  CHECK(offsetof(proto::SceneHeader, tool_slip_speed_m_s) == 84);
  CHECK(offsetof(proto::SceneHeader, static_offset) == 88);
  CHECK(offsetof(proto::SceneHeader, device) == 96);
  CHECK(offsetof(proto::SceneHeader, static_grid) == 160);
  CHECK(offsetof(proto::SceneHeader, materials) == 552);
  CHECK(offsetof(proto::SceneHeader, planes) == 1576);
  CHECK(offsetof(proto::SceneHeader, tool) == 3112);
  CHECK(offsetof(proto::SceneHeader, field_count) == 80);
  CHECK(offsetof(proto::SceneHeader, fields) == 3368);
  CHECK(offsetof(proto::SceneHeader, model_offset) == 73408);
  CHECK(offsetof(proto::SceneHeader, hand_count) == 73432);
  CHECK(offsetof(proto::SceneHeader, hand) == 73436);
  CHECK(offsetof(proto::SceneHeader, hands) == 73440);
  CHECK(sizeof(proto::SceneHeader) == 73536);
  CHECK(offsetof(proto::SceneHeader, touch_lists) == 73000);
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
  CHECK(offsetof(proto::SnapshotHeader, publish_time_ns) == 32);
  CHECK(offsetof(proto::SnapshotHeader, tool_time_ns) == 48);
  CHECK(offsetof(proto::SnapshotHeader, tool_work_J) == 56);
  CHECK(offsetof(proto::SnapshotHeader, step_ns) == 64);
  CHECK(offsetof(proto::SnapshotHeader, contacts) == 72);
  CHECK(offsetof(proto::SnapshotHeader, state_bytes) == 80);
  CHECK(offsetof(proto::SnapshotHeader, grid) == 104);
  CHECK(sizeof(proto::SnapshotHeader) == 496);

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

  CHECK(proto::kMaxFields == 512);
  CHECK(proto::kBrickCoefficients == 216);
  CHECK(proto::kFieldPoint == 0xFFFFFFFF);
  CHECK(offsetof(proto::FieldShape, brick_m) == 12);
  CHECK(offsetof(proto::FieldShape, bricks) == 16);
  CHECK(offsetof(proto::FieldShape, fine_count) == 28);
  CHECK(offsetof(proto::FieldShape, centre_m) == 32);
  CHECK(offsetof(proto::FieldShape, bounding_radius_m) == 44);
  CHECK(offsetof(proto::FieldShape, has_stiffness) == 48);
  CHECK(offsetof(proto::FieldShape, kind) == 52);
  CHECK(sizeof(proto::FieldShape) == 56);
  CHECK(offsetof(proto::FieldState, orientation_xyzw) == 12);
  CHECK(offsetof(proto::FieldState, velocity_m_s) == 28);
  CHECK(offsetof(proto::FieldState, angular_velocity_rad_s) == 40);
  CHECK(sizeof(proto::FieldState) == 56);
  CHECK(offsetof(proto::FieldBody, offset) == 56);
  CHECK(offsetof(proto::FieldBody, rest) == 64);
  CHECK(offsetof(proto::FieldBody, moving) == 120);
  CHECK(offsetof(proto::FieldBody, material) == 124);
  CHECK(offsetof(proto::FieldBody, body) == 128);
  CHECK(sizeof(proto::FieldBody) == 136);
  CHECK(sizeof(proto::FieldRecord) == 112);

  CHECK(sizeof(proto::SphereState) == 24);
  CHECK(offsetof(proto::SphereRecord, before) == 24);
  CHECK(offsetof(proto::SphereRecord, radius_m) == 48);
  CHECK(offsetof(proto::SphereRecord, material) == 52);
  CHECK(offsetof(proto::SphereRecord, body) == 56);
  CHECK(sizeof(proto::SphereRecord) == 64);
}

TEST_CASE("A tool segment is its header, its path and two slots", "[layout]") {
  const TestSession session;
  ToolWriter writer(session.name(), 1'000'000, proto::Clock::kVirtual, 0);

  CHECK(writer.header().size_bytes == 364544);
  CHECK(writer.header().slot_offset == std::array<std::uint64_t, 2>{360960, 361344});
  CHECK(writer.header().payload_bytes == 296);
}

TEST_CASE("A scene segment is its header, its static spheres twice and two slots", "[layout]") {
  const TestSession session;
  SmallSceneWriter scene(session);
  const proto::SegmentHeader& header = scene.writer().header();

  // Starts of 8 cells a sphere and 512 more, to a multiple of 64 bytes.
  const std::size_t static_bytes = 64 * 10 + 2432 + 16 * 13 + 4 * 10;
  const std::size_t grid_bytes = 512 + 64 * 7 + 2304 + 16 * 10 + (4 * 7 + 4);
  const std::size_t payload_bytes = (grid_bytes + 63) / 64 * 64;
  const proto::TouchShape& lists = scene.writer().scene().touch_lists;
  CHECK(lists.offset == (73984 + static_bytes + 63) / 64 * 64);
  const std::size_t list_bytes =
      (std::size_t{lists.cell_count} * 4 + 4 + 63) / 64 * 64 + std::size_t{lists.entry_count} * 32;
  const std::size_t first_slot = (lists.offset + list_bytes + 63) / 64 * 64;
  CHECK(header.slot_offset[0] == first_slot);
  CHECK(header.slot_offset[1] == first_slot + 64 + (payload_bytes + 63) / 64 * 64);
  CHECK(header.payload_bytes == payload_bytes);
  CHECK(header.size_bytes % 4096 == 0);
}

TEST_CASE("Fields stand behind the touch lists, and their records behind the grid", "[layout]") {
  const TestSession session;
  const StaticScene scene = field_scene();
  SceneWriter writer(session.name(), scene, kMovingSpheres, kPeriod_ns, proto::Clock::kVirtual, 0);
  const auto to_line = [](std::size_t bytes) { return (bytes + 63) / 64 * 64; };

  const std::size_t static_bytes = 64 * 10 + 2432 + 16 * 13 + 4 * 10;
  const PublishedField &ball = scene.fields[0], &slab = scene.fields[1];
  const proto::TouchShape& lists = writer.scene().touch_lists;
  CHECK(lists.offset == to_line(73984 + static_bytes));
  const std::size_t list_bytes =
      to_line(std::size_t{lists.cell_count} * 4 + 4) + std::size_t{lists.entry_count} * 32;
  const std::size_t first = to_line(lists.offset + list_bytes),
                    second = to_line(first + ball.field->bytes());
  CHECK(writer.scene().fields[0].offset == first);
  CHECK(writer.scene().fields[1].offset == second);
  CHECK(writer.scene().fields[2].offset == first);
  CHECK(scene.fields[2].field == ball.field);
  CHECK(writer.header().slot_offset[0] == to_line(second + slab.field->bytes()));

  const std::size_t grid_bytes = 512 + 64 * 7 + 2304 + 16 * 10 + (4 * 7 + 4);
  CHECK(writer.header().payload_bytes == to_line(grid_bytes) + 112 * 2);
}

TEST_CASE("A field of known size takes the bytes that docs/protocol.md says", "[layout]") {
  const proto::FieldShape shape{.lowest_m = {},
                                .brick_m = 0.01F,
                                .bricks = {3, 4, 5},
                                .fine_count = 7,
                                .centre_m = {},
                                .bounding_radius_m = 0.1F,
                                .has_stiffness = 1,
                                .kind = 0};
  const collision::FieldLayout layout = collision::field_layout(shape);
  CHECK(layout.coarse == 0);
  CHECK(layout.numbers * 8 == 4 * 5 * 6 * 7);
  CHECK(layout.stiffness * 8 == 840 + 4 * 60);
  CHECK(layout.fine * 8 == 840 + 240 + 840);
  CHECK(layout.total_words * 8 == 840 + 240 + 840 + 864 * 7);
}

TEST_CASE("100 moving spheres make a payload of 14272 bytes", "[layout]") {
  const collision::GridLayout layout = collision::grid_layout(sizeof(proto::SnapshotHeader), 100);
  CHECK(layout.cell_capacity == 1312);
  CHECK(layout.records * 8 == 512);
  CHECK(layout.total_words * 8 == 14272);
}

}  // namespace
}  // namespace stillgrid::publication::layout_test
