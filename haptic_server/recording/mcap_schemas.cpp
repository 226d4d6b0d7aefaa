#include "haptic_server/recording/mcap_schemas.hpp"

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "haptic_server/safety/safety_flag.hpp"

namespace stillgrid::recording {
namespace {

using Json = nlohmann::ordered_json;
using Fields = std::initializer_list<std::pair<std::string_view, Json>>;

Json type(const char* name) {
  return {{"type", name}};
}
Json described(Json schema, const char* text) {
  schema["description"] = text;
  return schema;
}
Json list_of(Json items) {
  return {{"type", "array"}, {"items", std::move(items)}};
}

/// All of the fields are there always.
Json object(const char* title, Fields fields) {
  Json properties = Json::object(), required = Json::array();
  for (const auto& [name, schema] : fields) {
    properties[std::string(name)] = schema;
    required.push_back(name);
  }
  return {{"title", title}, {"type", "object"}, {"properties", properties}, {"required", required}};
}

Json choice(const char* title, std::initializer_list<const char*> names) {
  Json values = Json::array();
  for (const char* name : names) values.push_back({{"title", name}, {"const", values.size()}});
  return {{"title", title}, {"oneOf", values}};
}

Json numbers(const char* title, std::initializer_list<const char*> names) {
  Json schema = object(title, {});
  for (const char* name : names) {
    schema["properties"][name] = type("number");
    schema["required"].push_back(name);
  }
  return schema;
}

Json seconds(const char* title, bool is_signed) {
  Json sec = type("integer");
  if (!is_signed) sec["minimum"] = 0;
  return {
      {"type", "object"},
      {"title", title},
      {"properties",
       {{"sec", sec}, {"nsec", {{"type", "integer"}, {"minimum", 0}, {"maximum", 999999999}}}}}};
}

const Json kNumber = type("number"), kInteger = type("integer"), kText = type("string"),
           kYesNo = type("boolean"), kTime = seconds("time", false),
           kVector = numbers("foxglove.Vector3", {"x", "y", "z"}),
           kPoint = numbers("foxglove.Point3", {"x", "y", "z"}),
           kQuaternion = numbers("foxglove.Quaternion", {"x", "y", "z", "w"}),
           kColour = numbers("foxglove.Color", {"r", "g", "b", "a"}),
           kIndices = list_of({{"type", "integer"}, {"minimum", 0}}),
           kPose = object("foxglove.Pose", {{"position", kVector}, {"orientation", kQuaternion}});

/// A vector whose parts may be missing, where they were no numbers.
Json vector(const char* text) {
  Json schema = described(type("object"), text);
  for (const char* axis : {"x", "y", "z"}) schema["properties"][axis] = kNumber;
  return schema;
}

Json deletion() {
  return object("foxglove.SceneEntityDeletion",
                {{"timestamp", kTime},
                 {"type", choice("foxglove.SceneEntityDeletionType", {"MATCHING_ID", "ALL"})},
                 {"id", kText}});
}

Json line() {
  return object("foxglove.LinePrimitive",
                {{"type", choice("foxglove.LineType", {"LINE_STRIP", "LINE_LOOP", "LINE_LIST"})},
                 {"pose", kPose},
                 {"thickness", kNumber},
                 {"scale_invariant", kYesNo},
                 {"points", list_of(kPoint)},
                 {"color", kColour},
                 {"colors", list_of(kColour)},
                 {"indices", kIndices}});
}

Json text() {
  return object("foxglove.TextPrimitive", {{"pose", kPose},
                                           {"billboard", kYesNo},
                                           {"font_size", kNumber},
                                           {"scale_invariant", kYesNo},
                                           {"color", kColour},
                                           {"text", kText}});
}

Json model() {
  Json bytes = kText;
  bytes["contentEncoding"] = "base64";
  return object("foxglove.ModelPrimitive", {{"pose", kPose},
                                            {"scale", kVector},
                                            {"color", kColour},
                                            {"override_color", kYesNo},
                                            {"url", kText},
                                            {"media_type", kText},
                                            {"data", bytes}});
}

Json entity() {
  const Json arrow = object("foxglove.ArrowPrimitive", {{"pose", kPose},
                                                        {"shaft_length", kNumber},
                                                        {"shaft_diameter", kNumber},
                                                        {"head_length", kNumber},
                                                        {"head_diameter", kNumber},
                                                        {"color", kColour}});
  const Json cylinder = object("foxglove.CylinderPrimitive", {{"pose", kPose},
                                                              {"size", kVector},
                                                              {"bottom_scale", kNumber},
                                                              {"top_scale", kNumber},
                                                              {"color", kColour}});
  const Json triangles = object("foxglove.TriangleListPrimitive", {{"pose", kPose},
                                                                   {"points", list_of(kPoint)},
                                                                   {"color", kColour},
                                                                   {"colors", list_of(kColour)},
                                                                   {"indices", kIndices}});
  const auto sized = [](const char* title) {
    return object(title, {{"pose", kPose}, {"size", kVector}, {"color", kColour}});
  };
  return object(
      "foxglove.SceneEntity",
      {{"timestamp", kTime},
       {"frame_id", kText},
       {"id", kText},
       {"lifetime", seconds("duration", true)},
       {"frame_locked", kYesNo},
       {"metadata", list_of(object("foxglove.KeyValuePair", {{"key", kText}, {"value", kText}}))},
       {"arrows", list_of(arrow)},
       {"cubes", list_of(sized("foxglove.CubePrimitive"))},
       {"spheres", list_of(sized("foxglove.SpherePrimitive"))},
       {"cylinders", list_of(cylinder)},
       {"lines", list_of(line())},
       {"triangles", list_of(triangles)},
       {"texts", list_of(text())},
       {"models", list_of(model())}});
}

}  // namespace

std::string tick_schema() {
  Json schema = object(
      "stillgrid.Tick",
      {{"time_s", described(kNumber, "Since the loop began")},
       {"velocity_m_s", vector("Of the tool, estimated; scene frame")},
       {"force_N", vector("On the hand, as commanded; scene frame")},
       {"rendered_force_N", vector("Before the safety chain; scene frame")},
       {"torque_N_m", vector("On the hand, as commanded, about the tool's origin; scene frame")},
       {"snapshot_id", described(kInteger, "Of the snapshot shown; 0 before the first")},
       {"alpha", described(kNumber, "Progress of the transition to that snapshot, 0 to 1")},
       {"contacts", described(kInteger, "That the force is the sum of")},
       {"age_s", described(kNumber, "Of the simulated state shown")},
       {"tick_ns", described(kInteger, "The tick's work; 0 in lockstep")},
       {"flags", described(kText, "What intervened in the tick, joined by |")}});
  schema["required"] = {"time_s", "snapshot_id", "contacts", "tick_ns", "flags"};
  return schema.dump();
}

std::string flags_schema() {
  Json schema = object("stillgrid.Flags", {});
  for (const std::string_view name : safety::kSafetyFlagNames) {
    schema["properties"][std::string(name)] = kYesNo;
    schema["required"].push_back(name);
  }
  return described(schema, "What intervened from this tick on; a message a change").dump();
}

std::string frame_transform_schema() {
  return object("foxglove.FrameTransform", {{"timestamp", kTime},
                                            {"parent_frame_id", kText},
                                            {"child_frame_id", kText},
                                            {"translation", kVector},
                                            {"rotation", kQuaternion}})
      .dump();
}

std::string scene_update_schema() {
  return object("foxglove.SceneUpdate",
                {{"deletions", list_of(deletion())}, {"entities", list_of(entity())}})
      .dump();
}

}  // namespace stillgrid::recording
