#include "shared/tools/scene_viewer/frame.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "proto/device_plugin.h"
#include "shared/tools/scene_viewer/frame_moment.hpp"
#include "tests/shared/publication/relay_words.hpp"
#include "tests/shared/publication/small_scene.hpp"
#include "tests/shared/publication/tampering.hpp"

namespace stillgrid::scene_viewer::frame_test {
namespace {

using Json = nlohmann::json;
constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

struct Decoded {
  Json head;
  std::map<std::string, std::vector<float>> arrays;
};

Decoded decode(const std::string& message) {
  std::uint32_t length = 0;
  std::memcpy(&length, message.data(), sizeof length);
  REQUIRE(length % 4 == 0);
  Decoded decoded{Json::parse(message.substr(4, length)), {}};
  std::size_t offset = 4 + length;
  for (const Json& array : decoded.head["arrays"]) {
    std::vector<float> values(array["count"].get<std::size_t>());
    REQUIRE(offset + 4 * values.size() <= message.size());
    if (!values.empty()) std::memcpy(values.data(), message.data() + offset, 4 * values.size());
    offset += 4 * values.size();
    decoded.arrays[array["name"]] = values;
  }
  CHECK(offset == message.size());
  return decoded;
}

publication::SceneView view_of(const publication::TestSession& session) {
  return publication::SceneView(*publication::SegmentReader::open(
      session.name(), proto::SegmentKind::kScene, proto::kSceneLayoutHash));
}

/// A tick that displayed snapshot `snapshot_id` of the scene half way from the one before.
proto::ToolState half_way(const publication::SceneView& scene, std::uint64_t snapshot_id) {
  proto::ToolState state{};
  state.orientation_xyzw = {0.0, 0.0, 0.0, 1.0};
  state.tick = 12;
  state.before.flags = proto::kFlagFaded | proto::kFlagSwept;
  proto::DisplayedSnapshot& shown = state.before.displayed;
  shown.scene_epoch = scene.header().epoch;
  shown.snapshot_id = snapshot_id;
  shown.alpha = 0.5;
  state.device = {.told = STILLGRID_STATE_GRIPPER,
                  .status = STILLGRID_STATUS_HOT,
                  .status_known = STILLGRID_STATUS_HOT | STILLGRID_STATUS_ENABLED,
                  .temperature_C = 40.0F,  // not told
                  .gripper_m = 0.02,
                  .gripper_force_N = -1.5,
                  .axes = {}};
  return state;
}

Frame frame_of(const publication::SceneView& scene, std::uint64_t shown) {
  Frame frame;
  frame.now_ns = 4 * publication::kPeriod_ns;
  frame.scene_epoch = scene.header().epoch;
  frame.snapshot = reading::read_snapshot(scene, kAll);
  frame.tool = half_way(scene, shown);
  return frame;
}

TEST_CASE("A frame tells both snapshots and the displayed one between them", "[frame]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  for (int snapshot = 0; snapshot < 4; ++snapshot) writer.publish_next();
  const publication::SceneView scene = view_of(session);

  const auto [head, arrays] = decode(frame_message(frame_of(scene, 4)));

  CHECK(head["snapshot_id"] == 4);
  CHECK(head["snapshot"]["history_count"] == 2);
  CHECK(head["snapshot"]["age_s"] == 0.0);
  CHECK(head["snapshot"]["tool_work_J"] == 1.0);
  CHECK(head["snapshot"]["state_time_s"].get<double>() == Approx(0.12));
  CHECK(head["display"]["snapshot_id"] == 4);
  CHECK(head["tool"]["flags"] == Json({"faded", "swept"}));
  CHECK(head["tool"]["device"] == Json{{"status", STILLGRID_STATUS_HOT},
                                       {"status_known", 10},
                                       {"temperature_C", nullptr},
                                       {"gripper_m", 0.02},
                                       {"gripper_force_N", -1.5},
                                       {"axes", nullptr}});
  for (const auto& [name, snapshot] :
       {std::pair{"newest", 4.0}, {"previous", 3.0}, {"displayed", 3.5}}) {
    REQUIRE(arrays.at(name).size() == 3 * publication::kMovingSpheres);
    CHECK(arrays.at(name)[3 * 2] == Approx(0.06));
    CHECK(arrays.at(name)[3 * 2 + 1] == Approx(0.004 * snapshot));
  }
  CHECK(arrays.at("voxels").size() == 4 * arrays.at("voxel_count").size());
}

TEST_CASE(
    "A tick of an earlier snapshot is displayed where that was, one of another scene not at all",
    "[frame]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  for (int snapshot = 0; snapshot < 4; ++snapshot) writer.publish_next();
  const publication::SceneView scene = view_of(session);

  const auto earlier = decode(frame_message(frame_of(scene, 3)));
  CHECK(earlier.arrays.at("displayed")[1] == Approx(0.004 * 2.5));
  const auto is_displayed = [&](auto&& change) {
    Frame frame = frame_of(scene, 4);
    change(frame);
    const auto [head, arrays] = decode(frame_message(frame));
    CHECK(head["display"].is_null() == arrays.at("displayed").empty());
    return !head["display"].is_null();
  };
  CHECK(is_displayed([](Frame&) {}));
  CHECK_FALSE(is_displayed([](Frame& f) { ++f.tool->before.displayed.scene_epoch; }));
  CHECK_FALSE(is_displayed([](Frame& f) { f.tool->before.displayed.snapshot_id = 0; }));
  CHECK_FALSE(is_displayed([](Frame& f) { f.tool->before.displayed.snapshot_id = 5; }));
  CHECK_FALSE(is_displayed([](Frame& f) { f.tool.reset(); }));
}

TEST_CASE("Whatever a writer wrote into a snapshot the frame is valid and bounded", "[frame]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const publication::SceneView scene = view_of(session);
  const publication::Tampering memory(session.path(proto::SegmentKind::kScene));
  const auto& header = memory.at<proto::SegmentHeader>(0);
  const std::size_t words = header.payload_bytes / 8;
  auto* payload = &memory.at<std::uint64_t>(header.slot_offset[1] + sizeof(proto::SlotHeader));
  const std::vector<std::uint64_t> sound(payload, payload + words);
  std::mt19937_64 random(1);
  std::size_t with_voxels = 0;
  for (int round = 0; round < 300; ++round) {
    const std::size_t range = round % 2 == 0 ? sizeof(proto::SnapshotHeader) / 8 : words;
    for (int i = 0; i < 1 + round % 20; ++i) {
      const std::uint64_t bits = random();
      payload[random() % range] ^= round % 3 == 0 ? std::uint64_t{1} << (bits % 64) : bits;
    }
    payload[0] = sound[0];  // under another number it is not believed
    const Frame frame = frame_of(scene, 1);
    const std::string message = frame_message(frame);
    REQUIRE(moment_of(message));  // kept, it opens again
    const auto [head, arrays] = decode(message);
    REQUIRE(arrays.at("newest").size() <= 3 * publication::kMovingSpheres);
    REQUIRE(arrays.at("voxel_count").size() <= publication::kMovingSpheres);
    if (!arrays.at("voxels").empty()) ++with_voxels;
    if (round % 4 == 3) std::copy(sound.begin(), sound.end(), payload);
  }
  CHECK(with_voxels > 50);
}

TEST_CASE("A frame tells of each segment how its relay hears the other side", "[frame]") {
  Frame frame;
  frame.sim = reading::Life::kAlive;
  frame.hand = reading::Life::kSilent;
  frame.sim_relay = publication::lossy_figures();
  frame.hand_relay = publication::lonely_figures();

  const std::string message = frame_message(frame);

  REQUIRE(moment_of(message));
  const Json head = decode(message).head;
  CHECK(head["sim"] == "alive");
  CHECK(head["hand"] == "silent");
  CHECK(head["sim_relay"]["connected"] == true);
  CHECK(head["sim_relay"]["clock_offset_ns"] == -1'234'567'890'123);
  CHECK(head["sim_relay"]["lost"] == 1'002);
  CHECK(head["hand_relay"]["connected"] == false);
  CHECK(head["hand_relay"]["round_trip_ns"].is_null());
}

TEST_CASE("A kept frame with a relay's figures that are none is damaged", "[frame]") {
  Frame frame;
  frame.sim_relay = publication::lossy_figures();
  const std::string sound = frame_message(frame);
  REQUIRE(moment_of(sound));
  for (const auto& [from, to] : {std::pair{"\"lost\":1002", "\"lost\":-100"},
                                 {"\"lost\"", "\"list\""},
                                 {"true", "1234"},
                                 {"20340000", "\"034000\""},
                                 {"\"hand_relay\":null", "\"hand_relay\":1234"}}) {
    INFO(from);
    std::string damaged = sound;
    REQUIRE(damaged.find(from) != std::string::npos);
    damaged.replace(damaged.find(from), std::string_view(from).size(), to);
    CHECK_FALSE(moment_of(damaged));
  }
}

TEST_CASE("Before there is anything a frame says so", "[frame]") {
  const auto [head, arrays] = decode(frame_message({}));
  CHECK(head["sim"] == "absent");
  CHECK(head["snapshot_id"].is_null());
  CHECK(head["tool"].is_null());
  CHECK(head["snapshot"].is_null());
  CHECK(head["sim_relay"].is_null());
  CHECK(head["hand_relay"].is_null());
  CHECK(arrays.at("newest").empty());
}

}  // namespace
}  // namespace stillgrid::scene_viewer::frame_test
