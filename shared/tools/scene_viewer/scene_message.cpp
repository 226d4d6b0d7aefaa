#include "shared/tools/scene_viewer/scene_message.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "proto/safety_flag.hpp"
#include "shared/files/json_number.hpp"
#include "shared/files/text_file.hpp"
#include "shared/reading/snapshot.hpp"
#include "shared/tools/scene_viewer/checked_json.hpp"
#include "shared/tools/scene_viewer/voxels.hpp"
#include "shared/tools/segment_inspect/inspection_json.hpp"

namespace stillgrid::scene_viewer {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
constexpr std::size_t kLongestName = sizeof(proto::SceneHeader::name) - 1;
constexpr double kPlainTool_m = 0.005;  // radius

std::string_view name_of(ViewKind kind) {
  switch (kind) {
    case ViewKind::kSaved:
      return "view";
    case ViewKind::kRecording:
      return "recording";
    case ViewKind::kSession:
      break;
  }
  return "session";
}

Json opening(ViewKind kind, const std::string& session, const std::string& key) {
  return {{"session", session},
          {"source", name_of(kind)},
          {"scene_key", key},
          {"flags", proto::kSafetyFlagNames}};
}

void add_spheres(Json& json, std::span<const proto::SphereRecord> moving,
                 std::span<const proto::SphereRecord> static_records) {
  Json radius_m = Json::array(), body = Json::array(), material = Json::array(),
       static_place_m = Json::array();
  for (const auto spheres : {moving, static_records})
    for (const proto::SphereRecord& record : spheres) {
      radius_m.push_back(files::json_number::number(record.radius_m));
      body.push_back(record.body);
      material.push_back(record.material);
    }
  for (const proto::SphereRecord& record : static_records)
    for (const float x : record.newest.position_m)
      static_place_m.push_back(files::json_number::number(x));
  json["spheres"] = {
      {"count", moving.size()},          {"static_count", static_records.size()},
      {"radius_m", std::move(radius_m)}, {"body", std::move(body)},
      {"material", std::move(material)}, {"static_position_m", std::move(static_place_m)}};
}

void add_voxels(Json& json, std::span<const OccupiedVoxel> voxels) {
  Json box_m = Json::array(), count = Json::array();
  for (const OccupiedVoxel& voxel : voxels) {
    for (const float x : voxel.centre_m) box_m.push_back(files::json_number::number(x));
    box_m.push_back(files::json_number::number(voxel.edge_m));
    count.push_back(voxel.spheres);
  }
  json["static_voxels"] = {{"box_m", std::move(box_m)}, {"count", std::move(count)}};
}

bool is_index(const Json& json, std::size_t count) {
  return json.is_number_unsigned() && json.get<std::size_t>() < count;
}

/// A point of a surface: as many weights as spheres, or the place of one that has none.
bool is_point(const Json& json, std::size_t sphere_count) {
  const Json &spheres = at(json, "spheres"), &weights = at(json, "weights");
  if (json.contains("still_m") && !are_numbers_or_null(json["still_m"], 3)) return false;
  return spheres.is_array() && weights.is_array() && spheres.size() == weights.size() &&
         std::all_of(spheres.begin(), spheres.end(),
                     [&](const Json& number) { return is_index(number, sphere_count); }) &&
         std::all_of(weights.begin(), weights.end(),
                     [](const Json& weight) { return weight.is_number(); });
}

/// Triangles or lines between the vertices.
bool are_faces(const Json& json, std::size_t corners, std::size_t vertex_count) {
  return json.is_array() && std::all_of(json.begin(), json.end(), [&](const Json& face) {
           return face.is_array() && face.size() == corners &&
                  std::all_of(face.begin(), face.end(),
                              [&](const Json& vertex) { return is_index(vertex, vertex_count); });
         });
}

bool is_surface(const Json& json, std::size_t sphere_count) {
  const Json& vertices = at(json, "vertices");
  if (!at(json, "body").is_number_unsigned() || !vertices.is_array()) return false;
  const bool has_lines = json.contains("lines");
  if (!has_lines && !json.contains("triangles")) return false;
  return std::all_of(vertices.begin(), vertices.end(),
                     [&](const Json& point) { return is_point(point, sphere_count); }) &&
         are_faces(json[has_lines ? "lines" : "triangles"], has_lines ? 2 : 3, vertices.size());
}

/// A list of so many whole numbers.
bool are_whole(const Json& json, std::size_t count) {
  return json.is_array() && json.size() == count &&
         std::all_of(json.begin(), json.end(),
                     [](const Json& value) { return value.is_number_unsigned(); });
}

/// The spheres of a saved scene: lists of as many as it counts.
bool are_spheres(const Json& json) {
  constexpr std::size_t kMax = 1U << 30U;
  for (const char* name : {"count", "static_count"})
    if (!is_index(at(json, name), kMax)) return false;
  const auto static_count = json["static_count"].get<std::size_t>();
  const std::size_t count = json["count"].get<std::size_t>() + static_count;
  return are_numbers_or_null(at(json, "radius_m"), count) && are_whole(at(json, "body"), count) &&
         are_whole(at(json, "material"), count) &&
         are_numbers_or_null(at(json, "static_position_m"), 3 * static_count);
}

/// The static grid of a saved scene; what has no scene has none.
bool is_static_grid(const Json& scene) {
  return !scene.contains("static_grid") || are_levels(at(scene["static_grid"], "levels"));
}

/// The static voxels of a saved scene.
bool are_voxels(const Json& json) {
  const Json& count = at(json, "count");
  return are_whole(count, count.size()) && are_numbers_or_null(at(json, "box_m"), 4 * count.size());
}

/// Names of bodies, which files of before do not have.
bool are_names(const Json& json) {
  return json.is_null() ||
         (json.is_array() &&
          std::all_of(json.begin(), json.end(), [](const Json& name) { return name.is_string(); }));
}

/// What was expected of a file of surfaces; empty for a sound one.
std::string fault_of(const Json& json) {
  if (!at(json, "spheres").is_number_unsigned() || !at(json, "bodies").is_array())
    return "JSON with \"spheres\" and a list \"bodies\", as sim_server --surfaces writes it";
  if (!are_names(at(json, "names"))) return "a list \"names\" of texts, one a body";
  const auto sphere_count = json["spheres"].get<std::size_t>();
  const Json& bodies = json["bodies"];
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (!is_surface(bodies[i], sphere_count))
      return "vertices of spheres and weights, and triangles or lines between them, in bodies[" +
             std::to_string(i) + "]";
  return {};
}

}  // namespace

std::string scene_message(const publication::SceneView& view, const std::string& session,
                          const std::string& key, std::span<const proto::SphereRecord> moving,
                          const Surfaces& surfaces, std::uint64_t tick_period_ns) {
  Json json = opening(ViewKind::kSession, session, key);
  json.update(segment_inspect::json_of_fixed_part(view, {.max_spheres = 0}));
  for (const char* name : {"static_spheres", "static_spheres_left_out", "moving_capacity"})
    json.erase(name);
  json["period_s"] = static_cast<double>(view.header().period_ns) * 1e-9;
  json["tick_period_s"] =
      tick_period_ns != 0 ? Json(static_cast<double>(tick_period_ns) * 1e-9) : Json();
  const auto static_records = reading::static_spheres(view, kAll);
  add_spheres(json, moving, static_records);
  add_voxels(json, occupied_voxels(view.static_grid().shape, reading::static_bounds(view)));
  const bool fit =
      surfaces.sphere_count == moving.size() + static_records.size() &&
      (surfaces.scene.empty() || json["name"] == surfaces.scene.substr(0, kLongestName));
  json["surfaces"] = fit ? Json::parse(surfaces.text) : Json();
  return segment_inspect::text_of(json);
}

std::string empty_scene_message(ViewKind kind, const std::string& name, const std::string& key) {
  Json json = opening(kind, name, key);
  json["name"] = name;
  json["materials"] = json["planes"] = Json::array();
  json["tool_spheres"] = {{{"position_m", {0.0, 0.0, 0.0}}, {"radius_m", kPlainTool_m}}};
  json["period_s"] = json["tick_period_s"] = Json();
  add_spheres(json, {}, {});
  add_voxels(json, {});
  json["surfaces"] = Json();
  return segment_inspect::text_of(json);
}

std::optional<SavedScene> saved_scene(const std::string& message) {
  Json json = parse_shallow<Json>(message);
  if (!at(json, "scene_key").is_string() || !are_spheres(at(json, "spheres")) ||
      !is_static_grid(json) || !are_voxels(at(json, "static_voxels")) ||
      !json.contains("surfaces") ||
      (!json["surfaces"].is_null() && !fault_of(json["surfaces"]).empty()))
    return std::nullopt;
  json["source"] = name_of(ViewKind::kSaved);
  return SavedScene{json["scene_key"].get<std::string>(), segment_inspect::text_of(json)};
}

std::string sessions_message(const std::string& named, const std::vector<std::string>& running) {
  return segment_inspect::text_of({{"named", named}, {"running", running}});
}

std::string status_message(const ViewStatus& status) {
  return segment_inspect::text_of({{"live", status.live},
                                   {"first_frame", status.first_frame},
                                   {"last_frame", status.last_frame},
                                   {"sim", name_of(status.sim)},
                                   {"hand", name_of(status.hand)},
                                   {"now_s", status.now_s},
                                   {"scene_key", status.scene_key},
                                   {"note", status.note},
                                   {"sim_command", status.sim_command},
                                   {"hand_command", status.hand_command}});
}

Surfaces read_surfaces(const std::string& file) {
  constexpr std::uintmax_t kMaxBytes = 256 * files::kMiB;
  Surfaces surfaces;
  surfaces.text = files::read_text(file, kMaxBytes);
  const Json json = Json::parse(surfaces.text, nullptr, false);
  const std::string fault = fault_of(json);
  if (!fault.empty()) throw std::runtime_error("--surfaces: " + file + ": expected " + fault);
  surfaces.sphere_count = json["spheres"].get<std::size_t>();
  if (at(json, "scene").is_string()) surfaces.scene = json["scene"].get<std::string>();
  return surfaces;
}

}  // namespace stillgrid::scene_viewer
