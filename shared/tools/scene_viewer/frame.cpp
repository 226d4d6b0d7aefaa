#include "shared/tools/scene_viewer/frame.hpp"

#include <nlohmann/json.hpp>
#include <vector>

#include "shared/files/json_number.hpp"
#include "shared/reading/displayed.hpp"
#include "shared/reading/relay_json.hpp"
#include "shared/tools/scene_viewer/binary_message.hpp"
#include "shared/tools/scene_viewer/voxels.hpp"
#include "shared/tools/segment_inspect/inspection_json.hpp"

namespace stillgrid::scene_viewer {
namespace {

using Json = nlohmann::ordered_json;
using files::json_number::number;
using files::json_number::numbers;

/// Of the newest snapshot; where no snapshot is known, of the one that was displayed.
Json snapshot_id_json(const Frame& frame) {
  if (frame.snapshot) return frame.snapshot->snapshot_id;
  const std::uint64_t shown = frame.tool ? frame.tool->before.displayed.snapshot_id : 0;
  return shown != 0 ? Json(shown) : Json();
}

Json state_json(const Frame& frame) {
  if (!frame.snapshot) return {};
  const proto::SnapshotHeader& header = frame.snapshot->header;
  const auto time_s = [&](std::uint64_t time_ns) { return number(frame.axis.seconds(time_ns)); };
  return {{"state_time_s", time_s(header.state_time_ns[0])},
          {"publish_time_s", time_s(header.publish_time_ns[0])},
          {"tool_time_s", header.tool_time_ns != 0 ? time_s(header.tool_time_ns) : Json()},
          {"age_s", TimeAxis{header.state_time_ns[0]}.seconds(frame.now_ns)},
          {"step_ms", static_cast<double>(header.step_ns) * 1e-6},
          {"contacts", header.contacts},
          {"tool_work_J", number(header.tool_work_J)},
          {"history_count", header.history_count}};
}

Json levels_json(const Frame& frame) {
  Json levels = Json::array();
  if (!frame.snapshot) return levels;
  const proto::GridShape& grid = frame.snapshot->header.grid;
  for (std::uint32_t i = 0; i < grid.level_count; ++i)
    levels.push_back({{"voxel_m", number(grid.levels[i].voxel_m)},
                      {"bounding_radius_m", number(grid.levels[i].bounding_radius_m)},
                      {"cells", grid.levels[i].cells}});
  return levels;
}

/// What the last tick displayed, as the history of the frame's snapshot tells it.
std::optional<proto::DisplayedSnapshot> displayed_snapshot(const Frame& frame) {
  if (!frame.snapshot || !frame.tool) return std::nullopt;
  return reading::displayed_in(frame.tool->before.displayed, frame.scene_epoch,
                               frame.snapshot->snapshot_id);
}

Json display_json(const std::optional<proto::DisplayedSnapshot>& shown) {
  if (!shown) return {};
  return {{"snapshot_id", shown->snapshot_id},
          {"alpha", shown->alpha},
          {"age_s", shown->age_s},
          {"is_local", shown->is_local != 0},
          {"local_ticks", shown->local_ticks}};
}

Json tool_json(const proto::ToolState& state, const TimeAxis& axis) {
  Json flags = Json::array();
  for (std::size_t i = 0; i < proto::kSafetyFlagNames.size(); ++i)
    if ((state.before.flags & (1U << i)) != 0) flags.push_back(proto::kSafetyFlagNames[i]);
  return {{"time_s", axis.seconds(state.time_ns)},
          {"tick", state.tick},
          {"position_m", numbers(state.position_m)},
          {"orientation_xyzw", numbers(state.orientation_xyzw)},
          {"velocity_m_s", numbers(state.velocity_m_s)},
          {"force_N", numbers(state.force_N)},
          {"torque_N_m", numbers(state.before.torque_N_m)},
          {"contacts", state.before.contacts},
          {"age_s", state.before.displayed.age_s},
          {"flags", std::move(flags)},
          {"device", segment_inspect::json_of(state.device)}};
}

Json others_json(const Frame& frame) {
  Json others = Json::array();
  for (const OtherHand& hand : frame.others) {
    Json spheres = Json::array();
    for (const proto::ToolSphere& sphere : hand.spheres)
      spheres.push_back(
          {{"position_m", numbers(sphere.position_m)}, {"radius_m", sphere.radius_m}});
    others.push_back({{"name", hand.name},
                      {"tool", tool_json(hand.tool, frame.axis)},
                      {"tool_spheres", std::move(spheres)}});
  }
  return others;
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
  const std::optional<proto::DisplayedSnapshot> shown = displayed_snapshot(frame);
  std::vector<float> newest, previous, displayed, voxels;
  std::vector<std::uint32_t> voxel_count;
  const auto append = [](std::vector<float>& to, const std::array<float, 3>& at_m) {
    to.insert(to.end(), at_m.begin(), at_m.end());
  };
  if (frame.snapshot) {
    for (const proto::SphereRecord& record : frame.snapshot->spheres) {
      append(newest, record.newest.position_m);
      append(previous, record.before.position_m);
      if (shown) append(displayed, reading::displayed_m(record, *shown));
    }
    for (const OccupiedVoxel& voxel :
         occupied_voxels(frame.snapshot->header.grid, frame.snapshot->swept_bounds)) {
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
       {"sim_relay", reading::relay_json(frame.sim_relay)},
       {"hand_relay", reading::relay_json(frame.hand_relay)},
       {"snapshot_id", snapshot_id_json(frame)},
       {"snapshot", state_json(frame)},
       {"grid", {{"levels", levels_json(frame)}}},
       {"display", display_json(shown)},
       {"tool", frame.tool ? tool_json(*frame.tool, frame.axis) : Json()},
       {"others", others_json(frame)},
       {"ticks", ticks_json(frame.ticks)}},
      {array_of("newest", newest), array_of("previous", previous), array_of("displayed", displayed),
       array_of("voxels", voxels), array_of("voxel_count", voxel_count)});
}

}  // namespace stillgrid::scene_viewer
