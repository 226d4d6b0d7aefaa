#include "shared/viewer/frame.hpp"

#include <nlohmann/json.hpp>
#include <vector>

#include "shared/collision/sphere_history.hpp"
#include "shared/inspection/json_number.hpp"
#include "shared/viewer/binary_message.hpp"
#include "shared/viewer/displayed.hpp"
#include "shared/viewer/voxels.hpp"

namespace stillgrid {
namespace {

using Json = nlohmann::ordered_json;
using json_number::number;
using json_number::numbers;

/// Of the newest image; where no image is known, of the one that was displayed.
Json generation_json(const Frame& frame) {
  if (frame.image) return frame.image->generation;
  const std::uint64_t shown = frame.tool ? frame.tool->before.displayed.generation : 0;
  return shown != 0 ? Json(shown) : Json();
}

Json image_json(const Frame& frame) {
  if (!frame.image) return {};
  const proto::SnapshotHeader& header = frame.image->header;
  const auto time_s = [&](std::uint64_t time_ns) { return number(frame.axis.seconds(time_ns)); };
  return {{"state_time_s", time_s(header.state_time_ns[0])},
          {"publish_time_s", time_s(header.publish_time_ns[0])},
          {"tool_time_s", header.tool_time_ns != 0 ? time_s(header.tool_time_ns) : Json()},
          {"age_s", TimeAxis{header.state_time_ns[0]}.seconds(frame.now_ns)},
          {"step_ms", static_cast<double>(header.step_ns) * 1e-6},
          {"contacts", header.contacts},
          {"foresight_ms", static_cast<double>(header.foresight_ns) * 1e-6},
          {"history_count", header.history_count}};
}

Json levels_json(const Frame& frame) {
  Json levels = Json::array();
  if (!frame.image) return levels;
  const proto::GridShape& grid = frame.image->header.grid;
  for (std::uint32_t i = 0; i < grid.level_count; ++i)
    levels.push_back({{"voxel_m", number(grid.levels[i].voxel_m)},
                      {"reach_m", number(grid.levels[i].reach_m)},
                      {"cells", grid.levels[i].cells}});
  return levels;
}

/// What the last tick displayed, as the history of the frame's image tells it.
std::optional<proto::DisplayedImage> displayed_image(const Frame& frame) {
  if (!frame.image || !frame.tool) return std::nullopt;
  const proto::DisplayedImage& shown = frame.tool->before.displayed;
  if (shown.generation == 0 || shown.scene_epoch != frame.scene_epoch ||
      shown.generation > frame.image->generation)
    return std::nullopt;
  return told_by_later(shown, frame.image->generation - shown.generation);
}

Json display_json(const std::optional<proto::DisplayedImage>& shown) {
  if (!shown) return {};
  return {{"generation", shown->generation},
          {"alpha", shown->alpha},
          {"weights", numbers(shown->position)},
          {"velocity_s", numbers(shown->velocity_s)},
          {"drift_s", shown->drift_s},
          {"answer_lag_s", shown->answer_lag_s},
          {"answer_N", shown->answer_N},
          {"shift_m", numbers(shown->shift_m)},
          {"age_s", shown->age_s}};
}

Json tool_json(const Frame& frame) {
  if (!frame.tool) return {};
  const proto::ToolState& state = *frame.tool;
  Json flags = Json::array();
  for (std::size_t i = 0; i < proto::kSafetyFlagNames.size(); ++i)
    if ((state.before.flags & (1U << i)) != 0) flags.push_back(proto::kSafetyFlagNames[i]);
  return {{"time_s", frame.axis.seconds(state.time_ns)},
          {"tick", state.tick},
          {"position_m", numbers(state.position_m)},
          {"orientation_xyzw", numbers(state.orientation_xyzw)},
          {"velocity_m_s", numbers(state.velocity_m_s)},
          {"force_N", numbers(state.force_N)},
          {"torque_N_m", numbers(state.before.torque_N_m)},
          {"contacts", state.before.contacts},
          {"age_s", state.before.displayed.age_s},
          {"flags", std::move(flags)}};
}

Json ticks_json(const TickSummary& ticks) {
  const auto percentiles = [](const TickPercentiles& us) {
    return Json{{"p50", us.p50}, {"p99", us.p99}, {"p999", us.p999}};
  };
  return {{"seen", ticks.seen},
          {"expected", ticks.expected},
          {"per_s", ticks.per_s},
          {"missed", ticks.missed},
          {"tick_us", percentiles(ticks.work_us)},
          {"wake_us", percentiles(ticks.wake_us)}};
}

}  // namespace

std::string frame_message(const Frame& frame) {
  const std::optional<proto::DisplayedImage> shown = displayed_image(frame);
  std::vector<float> newest, previous, displayed, voxels;
  std::vector<std::uint32_t> voxel_count;
  const auto append = [](std::vector<float>& to, const std::array<float, 3>& at_m) {
    to.insert(to.end(), at_m.begin(), at_m.end());
  };
  if (frame.image) {
    for (const proto::SphereRecord& record : frame.image->spheres) {
      append(newest, record.newest.position_m);
      append(previous, position_m(record, 1));
      if (shown) append(displayed, displayed_m(record, *shown));
    }
    for (const OccupiedVoxel& voxel :
         occupied_voxels(frame.image->header.grid, frame.image->covers)) {
      append(voxels, voxel.centre_m);
      voxels.push_back(voxel.edge_m);
      voxel_count.push_back(voxel.spheres);
    }
  }
  return binary_message(
      {{"frame", frame.number},
       {"time_s", frame.axis.seconds(frame.now_ns)},
       {"scene_key", frame.scene_key},
       {"sim", name_of(frame.sim)},
       {"hand", name_of(frame.hand)},
       {"generation", generation_json(frame)},
       {"image", image_json(frame)},
       {"grid", {{"levels", levels_json(frame)}}},
       {"display", display_json(shown)},
       {"tool", tool_json(frame)},
       {"ticks", ticks_json(frame.ticks)}},
      {array_of("newest", newest), array_of("previous", previous), array_of("displayed", displayed),
       array_of("voxels", voxels), array_of("voxel_count", voxel_count)});
}

}  // namespace stillgrid
