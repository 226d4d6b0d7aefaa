#include "haptic_server/recording/mcap_recording.hpp"

#include "haptic_server/recording/mcap_messages.hpp"
#include "haptic_server/recording/mcap_schemas.hpp"

namespace stillgrid::recording {

McapRecording::McapRecording(BlockFile& file, const RecordingHead& head,
                             std::uint64_t clock_offset_ns)
    : writer_(file, "stillgrid"), clock_offset_ns_(clock_offset_ns) {
  writer_.add_metadata("stillgrid", head);
  const char* const update = "foxglove.SceneUpdate";
  pose_ = writer_.add_channel("/tool/pose", "foxglove.FrameTransform", frame_transform_schema());
  tick_ = writer_.add_channel("/tool/tick", "stillgrid.Tick", tick_schema());
  flags_ = writer_.add_channel("/tool/flags", "stillgrid.Flags", flags_schema());
  tool_ = writer_.add_channel("/tool/spheres", update, scene_update_schema());
  fixed_ = writer_.add_channel("/scene/fixed", update, scene_update_schema());
  moving_ = writer_.add_channel("/scene/moving", update, scene_update_schema());
}

void McapRecording::add_row(const TickRow& row) {
  const std::uint64_t time_ns = row.clock_ns + clock_offset_ns_;
  const auto add = [&](std::uint16_t channel, std::uint64_t rows) {
    writer_.add_message(channel, time_ns, json_, rows);
    json_.clear();
  };
  if (last_flags_ != row.flags) {
    write_flags(row.flags, json_);
    add(flags_, 0);
    last_flags_ = row.flags;
  }
  write_pose(row, time_ns, json_);
  add(pose_, 0);
  write_tick(row, json_);
  add(tick_, 1);
}

void McapRecording::add_scene(const SceneSample& scene) {
  const std::uint64_t time_ns = scene.time_ns + clock_offset_ns_;
  const auto add = [&](std::uint16_t channel) {
    writer_.add_message(channel, time_ns, json_);
    json_.clear();
  };
  if (scene.fixed) {
    write_fixed(*scene.fixed, time_ns, json_);
    add(fixed_);
    write_tool(scene.fixed->tool, time_ns, json_);
    add(tool_);
  }
  write_spheres(scene.moving, time_ns, json_);
  add(moving_);
}

}  // namespace stillgrid::recording
