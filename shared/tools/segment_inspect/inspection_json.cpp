#include "shared/tools/segment_inspect/inspection_json.hpp"

#include <nlohmann/json.hpp>
#include <span>

#include "proto/device_plugin.h"
#include "shared/files/json_number.hpp"
#include "shared/reading/relay_json.hpp"
#include "shared/reading/snapshot.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/segment_inspect/inspection_text.hpp"

namespace stillgrid::segment_inspect {
namespace {

using Json = nlohmann::ordered_json;
using files::json_number::number;
using files::json_number::numbers;

template <class T>
Json optional(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

/// Of a history, only the snapshots that exist.
Json times(const std::array<std::uint64_t, proto::kHistoryLength>& times_ns, std::size_t count) {
  Json json = Json::array();
  for (std::size_t i = 0; i < count; ++i) json.push_back(times_ns[i]);
  return json;
}

/// 0, no time, is null; so is a promise of nothing more.
Json time(std::uint64_t time_ns) {
  return time_ns == 0 || time_ns == proto::kNever ? Json() : Json(time_ns);
}

Json header_json(const proto::SegmentHeader& header) {
  return {{"version", header.version},
          {"layout_hash", hexadecimal(header.layout_hash)},
          {"epoch", hexadecimal(header.epoch)},
          {"size_bytes", header.size_bytes},
          {"period_ns", header.period_ns},
          {"clock", name_of(header.clock)},
          {"writer_pid", header.writer_pid},
          {"start_ns", header.start_ns},
          {"slot_offset", header.slot_offset},
          {"payload_bytes", header.payload_bytes},
          {"latest", header.latest},
          {"heartbeat_ns", time(header.heartbeat_ns)},
          {"lockstep_sample_ns", time(header.lockstep_sample_ns)},
          {"lockstep_event_ns", time(header.lockstep_event_ns)}};
}

Json grid_json(const proto::GridShape& grid) {
  Json levels = Json::array();
  for (std::uint32_t i = 0; i < grid.level_count; ++i) {
    const proto::GridLevel& level = grid.levels[i];
    levels.push_back({{"voxel_m", number(level.voxel_m)},
                      {"bounding_radius_m", number(level.bounding_radius_m)},
                      {"lowest_voxel", level.lowest_voxel},
                      {"highest_voxel", level.highest_voxel},
                      {"cells", level.cells}});
  }
  return {{"spheres", grid.sphere_count}, {"levels", std::move(levels)}};
}

Json state_json(const proto::SphereState& snapshot) {
  return {{"position_m", numbers(snapshot.position_m)},
          {"velocity_m_s", numbers(snapshot.velocity_m_s)}};
}

/// snapshots: of which each sphere's history tells those before the newest; 0: no history.
Json spheres_json(const std::vector<proto::SphereRecord>& spheres, std::size_t snapshots) {
  Json json = Json::array();
  for (const proto::SphereRecord& record : spheres) {
    Json sphere = state_json(record.newest);
    sphere["radius_m"] = number(record.radius_m);
    sphere["material"] = record.material;
    sphere["body"] = record.body;
    if (snapshots > 0) sphere["history"] = Json::array();
    if (snapshots > 1) sphere["history"].push_back(state_json(record.before));
    json.push_back(std::move(sphere));
  }
  return json;
}

Json state_json(const proto::FieldState& state) {
  return {{"position_m", numbers(state.position_m)},
          {"orientation_xyzw", numbers(state.orientation_xyzw)},
          {"velocity_m_s", numbers(state.velocity_m_s)},
          {"angular_velocity_rad_s", numbers(state.angular_velocity_rad_s)}};
}

/// What stands of fields in the fixed part.
Json fields_json(std::span<const publication::SceneField> fields) {
  constexpr std::array<const char*, proto::kFieldKinds> kKinds = {"sampled", "box", "capsule",
                                                                  "cylinder"};
  Json json = Json::array();
  for (const publication::SceneField& field : fields) {
    const proto::FieldShape& shape = field.body.shape;
    json.push_back({{"body", field.body.body},
                    {"material", field.body.material},
                    {"moves", field.body.moving != 0},
                    {"cell_m", number(shape.brick_m / float{proto::kBrickCells})},
                    {"bricks", shape.bricks},
                    {"fine_bricks", shape.fine_count},
                    {"has_stiffness", shape.has_stiffness != 0},
                    {"kind", kKinds.at(shape.kind)},
                    {"lowest_m", numbers(shape.lowest_m)},
                    {"centre_m", numbers(shape.centre_m)},
                    {"bounding_radius_m", number(shape.bounding_radius_m)},
                    {"bytes", 8 * field.field.layout.total_words},
                    {"offset", field.body.offset},
                    {"rest", field.body.moving != 0 ? Json() : state_json(field.body.rest)}});
  }
  return json;
}

/// Of those that move; snapshots as of spheres_json().
Json fields_json(const std::vector<proto::FieldRecord>& fields, std::size_t snapshots) {
  Json json = Json::array();
  for (const proto::FieldRecord& record : fields) {
    Json field = state_json(record.history[0]);
    if (snapshots > 0) field["history"] = Json::array();
    if (snapshots > 1) field["history"].push_back(state_json(record.history[1]));
    json.push_back(std::move(field));
  }
  return json;
}

Json snapshot_json(const publication::SceneView& view, const JsonOptions& options) {
  const auto snapshot = reading::read_snapshot(view, options.max_spheres);
  if (!snapshot) return {};
  const proto::SnapshotHeader& header = snapshot->header;
  const auto snapshots = static_cast<std::size_t>(header.history_count);
  Json grid = grid_json(header.grid);
  grid["cells"] = snapshot->occupancy.cells;
  grid["occupied_cells"] = snapshot->occupancy.occupied_cells;
  grid["fullest_cell_spheres"] = snapshot->occupancy.fullest_cell;
  return {{"snapshot_id", snapshot->snapshot_id},
          {"history_count", snapshots},
          {"state_time_ns", times(header.state_time_ns, snapshots)},
          {"publish_time_ns", times(header.publish_time_ns, snapshots)},
          {"tool_time_ns", time(header.tool_time_ns)},
          {"tool_work_J", number(header.tool_work_J)},
          {"step_ns", header.step_ns},
          {"contacts", header.contacts},
          {"state",
           {{"bytes", header.state_bytes},
            {"tick", header.state_tick},
            {"hash", hexadecimal(header.state_hash)}}},
          {"grid", std::move(grid)},
          {"spheres", spheres_json(snapshot->spheres, options.history ? snapshots : 0)},
          {"spheres_left_out", header.grid.sphere_count - snapshot->spheres.size()},
          {"fields", fields_json(snapshot->fields, options.history ? snapshots : 0)}};
}

/// Unknown flags are left out.
Json flags_json(std::uint32_t flags) {
  Json json = Json::array();
  for (std::size_t i = 0; i < proto::kSafetyFlagNames.size(); ++i)
    if ((flags & (1U << i)) != 0) json.push_back(proto::kSafetyFlagNames[i]);
  return json;
}

Json tick_json(const proto::TickFigures& tick) {
  const proto::DisplayedSnapshot& shown = tick.displayed;
  return {{"torque_N_m", numbers(tick.torque_N_m)},
          {"contacts", tick.contacts},
          {"flags", flags_json(tick.flags)},
          {"work_ns", tick.work_ns},
          {"wake_up_latency_ns", tick.wake_up_latency_ns},
          {"missed_ticks", tick.missed_ticks},
          {"displayed",
           {{"scene_epoch", hexadecimal(shown.scene_epoch)},
            {"snapshot_id", shown.snapshot_id},
            {"alpha", number(shown.alpha)},
            {"age_s", number(shown.age_s)},
            {"is_local", shown.is_local != 0},
            {"local_ticks", shown.local_ticks}}}};
}

Json tool_json(const publication::ToolView& view) {
  const auto snapshot = reading::read_tool(view);
  if (!snapshot) return {};
  const proto::ToolState& state = snapshot->state;
  return {{"snapshot_id", snapshot->snapshot_id},
          {"time_ns", state.time_ns},
          {"tick", state.tick},
          {"position_m", numbers(state.position_m)},
          {"orientation_xyzw", numbers(state.orientation_xyzw)},
          {"velocity_m_s", numbers(state.velocity_m_s)},
          {"force_N", numbers(state.force_N)},
          {"buttons", state.buttons},
          {"device", json_of(state.device)},
          {"tick_before", tick_json(state.before)}};
}

Json segment_json(const reading::ObservedSegment* segment, const JsonOptions& options) {
  if (segment == nullptr) return {};
  Json json = json_of(segment->summary);
  if (segment->summary.header) json["header"] = header_json(*segment->summary.header);
  if (segment->scene) {
    json["fixed"] = json_of_fixed_part(*segment->scene, options);
    json["snapshot"] = snapshot_json(*segment->scene, options);
  }
  if (segment->tool) json["latest_state"] = tool_json(*segment->tool);
  return json;
}

}  // namespace

nlohmann::ordered_json json_of_fixed_part(const publication::SceneView& view,
                                          const JsonOptions& options) {
  const proto::SceneHeader& scene = view.scene();
  Json json{{"name", scene.name.data()},
            {"materials", Json::array()},
            {"planes", Json::array()},
            {"tool_spheres", Json::array()},
            {"tool_slip_speed_m_s", number(scene.tool_slip_speed_m_s)},
            {"device",
             {{"position_m", numbers(scene.device.position_m)},
              {"orientation_xyzw", numbers(scene.device.orientation_xyzw)},
              {"scale", number(scene.device.scale)}}},
            {"moving_capacity", scene.moving_capacity},
            {"model_bytes", scene.model_bytes},
            {"state_capacity", scene.state_capacity},
            {"static_grid", grid_json(scene.static_grid)}};
  for (std::size_t i = 0; i < scene.material_count; ++i) {
    const proto::Material& material = scene.materials[i];
    json["materials"].push_back({{"stiffness_N_per_m", number(material.stiffness_N_per_m)},
                                 {"damping_N_s_per_m", number(material.damping_N_s_per_m)},
                                 {"friction", number(material.friction)},
                                 {"slip_speed_m_s", number(material.slip_speed_m_s)}});
  }
  for (std::size_t i = 0; i < scene.plane_count; ++i) {
    const proto::Plane& plane = scene.planes[i];
    json["planes"].push_back({{"normal", numbers(plane.normal)},
                              {"offset_m", number(plane.offset_m)},
                              {"material", plane.material},
                              {"body", plane.body}});
  }
  for (std::size_t i = 0; i < scene.tool_sphere_count; ++i)
    json["tool_spheres"].push_back({{"position_m", numbers(scene.tool[i].position_m)},
                                    {"radius_m", number(scene.tool[i].radius_m)}});
  const auto spheres = reading::static_spheres(view, options.max_spheres);
  json["static_spheres"] = spheres_json(spheres, 0);
  json["static_spheres_left_out"] = view.static_grid().shape.sphere_count - spheres.size();
  json["fields"] = fields_json(view.fields());
  return json;
}

nlohmann::ordered_json json_of(const proto::DeviceFigures& device) {
  const auto told = [&](std::uint32_t bit, const Json& value) {
    return (device.told & bit) != 0 ? value : Json();
  };
  return {{"status", device.status & device.status_known},
          {"status_known", device.status_known},
          {"temperature_C", told(STILLGRID_STATE_TEMPERATURE, number(device.temperature_C))},
          {"gripper_m", told(STILLGRID_STATE_GRIPPER, number(device.gripper_m))},
          {"gripper_force_N", told(STILLGRID_STATE_GRIPPER, number(device.gripper_force_N))},
          {"axes", told(STILLGRID_STATE_AXES, numbers(device.axes))}};
}

nlohmann::ordered_json json_of(const reading::SegmentSummary& summary) {
  const auto& header = summary.header;
  const auto of_header = [&](auto&& value) { return header ? Json(value(*header)) : Json(); };
  Json json{{"session", summary.file.session},
            {"kind", name_of(summary.file.kind)},
            {"state", name_of(summary.state)},
            {"refusal", summary.refusal.empty() ? Json() : Json(summary.refusal)}};
  json["writer_pid"] = of_header([](const auto& h) { return h.writer_pid; });
  json["version"] = of_header([](const auto& h) { return h.version; });
  json["clock"] = of_header([](const auto& h) { return name_of(h.clock); });
  json["declared_rate_hz"] = of_header([](const auto& h) { return rate_of(h.period_ns); });
  json["measured_rate_hz"] = optional(summary.measured_rate_hz);
  json["snapshot_id"] = of_header([](const auto& h) { return h.latest; });
  json["age_s"] = optional(summary.age_s);
  json["moving_spheres"] = optional(summary.moving_spheres);
  json["static_spheres"] = optional(summary.static_spheres);
  json["size_bytes"] = summary.size_bytes;
  json["relay"] = reading::relay_json(summary.relay);
  return json;
}

nlohmann::ordered_json json_of(std::span<const reading::SegmentSummary> summaries) {
  Json json = Json::array();
  for (const reading::SegmentSummary& summary : summaries) json.push_back(json_of(summary));
  return json;
}

nlohmann::ordered_json json_of(const std::string& session, const reading::ObservedSegment* scene,
                               const reading::ObservedSegment* tool, const JsonOptions& options) {
  Json json{{"session", session}};
  json["scene"] = segment_json(scene, options);
  json["tool"] = segment_json(tool, options);
  json["now_ns"] = realtime::monotonic_ns();
  return json;
}

std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace stillgrid::segment_inspect
