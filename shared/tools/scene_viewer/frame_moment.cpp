#include "shared/tools/scene_viewer/frame_moment.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "shared/tools/scene_viewer/checked_json.hpp"

namespace stillgrid::scene_viewer {
namespace {

using Json = nlohmann::json;

bool is_state(const Json& json) {
  return json == "alive" || json == "silent" || json == "dead" || json == "absent";
}

/// Of the relay that writes a segment; views of before have none.
bool is_relay(const Json& relay) {
  if (relay.is_null()) return true;
  constexpr std::array kCounts = {"received", "received_bytes", "lost",
                                  "repeated", "out_of_order",   "late",
                                  "refused",  "partitions",     "longest_silence_ns"};
  constexpr std::array kMeasured = {"round_trip_ns", "clock_offset_ns", "clock_bound_ns"};
  return at(relay, "connected").is_boolean() &&
         std::all_of(kCounts.begin(), kCounts.end(),
                     [&](const char* count) { return at(relay, count).is_number_unsigned(); }) &&
         std::all_of(kMeasured.begin(), kMeasured.end(),
                     [&](const char* time) { return is_number_or_null(at(relay, time)); });
}

bool is_tool(const Json& tool) {
  if (tool.is_null()) return true;
  return at(tool, "tick").is_number_unsigned() && at(tool, "contacts").is_number_unsigned() &&
         at(tool, "time_s").is_number() && is_number_or_null(at(tool, "age_s")) &&
         at(tool, "flags").is_array() && are_numbers_or_null(at(tool, "position_m"), 3) &&
         are_numbers_or_null(at(tool, "orientation_xyzw"), 4) &&
         are_numbers_or_null(at(tool, "force_N"), 3);
}

/// Of the other hands; views of before have none.
bool are_others(const Json& head) {
  if (!head.is_object() || !head.contains("others")) return true;
  const auto is_sphere = [](const Json& sphere) {
    return are_numbers_or_null(at(sphere, "position_m"), 3) && at(sphere, "radius_m").is_number();
  };
  const auto is_other = [&](const Json& other) {
    const Json& spheres = at(other, "tool_spheres");
    return at(other, "name").is_string() && at(other, "tool").is_object() &&
           is_tool(other["tool"]) && spheres.is_array() &&
           std::all_of(spheres.begin(), spheres.end(), is_sphere);
  };
  return head["others"].is_array() &&
         std::all_of(head["others"].begin(), head["others"].end(), is_other);
}

/// Percentiles, and what is counted.
bool are_ticks(const Json& ticks) {
  const auto are_percentiles = [](const Json& us) {
    return at(us, "p50").is_number() && at(us, "p99").is_number() && at(us, "p999").is_number();
  };
  return at(ticks, "per_s").is_number() && at(ticks, "missed").is_number_unsigned() &&
         are_percentiles(at(ticks, "tick_us")) && are_percentiles(at(ticks, "wake_us"));
}

bool is_null_or_has_number(const Json& json, const char* name) {
  return json.is_null() || at(json, name).is_number();
}

/// The arrays, which are all that follows: three numbers a sphere, four and a count a voxel.
bool are_arrays(const Json& arrays, std::size_t bytes) {
  constexpr std::size_t kBytes = 4;  // of a number
  if (!arrays.is_array()) return false;
  std::map<std::string, std::size_t> counts;
  std::size_t told = 0;
  for (const Json& array : arrays) {
    const Json &name = at(array, "name"), &type = at(array, "type"), &count = at(array, "count");
    if (!name.is_string() || !count.is_number_unsigned() || count.get<std::size_t>() > bytes ||
        type != (name == "voxel_count" ? "u32" : "f32"))
      return false;
    counts[name.get<std::string>()] = count.get<std::size_t>();
    told += kBytes * count.get<std::size_t>();
  }
  for (const char* name : {"newest", "previous", "displayed", "voxels", "voxel_count"})
    if (!counts.contains(name)) return false;
  const std::size_t newest = counts["newest"], displayed = counts["displayed"];
  return counts.size() == arrays.size() && told == bytes && newest % 3 == 0 &&
         counts["previous"] == newest && (displayed == newest || displayed == 0) &&
         counts["voxels"] == 4 * counts["voxel_count"];
}

}  // namespace

std::optional<FrameMoment> moment_of(const std::string& frame_message) {
  constexpr std::size_t kLengthBytes = 4;
  if (frame_message.size() < kLengthBytes) return std::nullopt;
  std::size_t length = 0;
  for (std::size_t i = 0; i < kLengthBytes; ++i)
    length |= std::size_t{static_cast<unsigned char>(frame_message[i])} << (8 * i);
  const std::string_view rest = std::string_view(frame_message).substr(kLengthBytes);
  if (length > rest.size()) return std::nullopt;
  const Json head = Json::parse(rest.substr(0, length), nullptr, false);
  const bool is_sound =
      at(head, "frame").is_number_unsigned() && at(head, "time_s").is_number() &&
      at(head, "scene_key").is_string() && is_state(at(head, "sim")) &&
      is_state(at(head, "hand")) && is_relay(at(head, "sim_relay")) &&
      is_relay(at(head, "hand_relay")) && is_number_or_null(at(head, "snapshot_id")) &&
      is_null_or_has_number(at(head, "snapshot"), "step_ms") &&
      is_null_or_has_number(at(head, "display"), "alpha") && is_tool(at(head, "tool")) &&
      are_others(head) && are_levels(at(at(head, "grid"), "levels")) &&
      are_ticks(at(head, "ticks")) && are_arrays(at(head, "arrays"), rest.size() - length);
  if (!is_sound) return std::nullopt;
  return FrameMoment{head["time_s"].get<double>(), head["scene_key"].get<std::string>()};
}

}  // namespace stillgrid::scene_viewer
