#include "shared/tools/segment_inspect/inspection_json.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "shared/reading/snapshot.hpp"
#include "shared/tools/segment_inspect/inspection_text.hpp"
#include "tests/shared/publication/field_scene.hpp"
#include "tests/shared/publication/small_scene.hpp"
#include "tests/shared/publication/tampering.hpp"

namespace stillgrid::segment_inspect::inspection_json_test {
namespace {

using Json = nlohmann::ordered_json;
constexpr auto kScene = proto::SegmentKind::kScene;
constexpr auto kTool = proto::SegmentKind::kTool;

/// The JSON of a session that has a scene, as a script reads it.
Json session_json(const publication::TestSession& session, const JsonOptions& options = {}) {
  const reading::ObservedSegment scene = reading::observe({session.name(), kScene});
  return Json::parse(text_of(json_of(session.name(), &scene, nullptr, options)));
}

Eigen::Vector3f vector(const Json& json) {
  const auto values = json.get<std::array<float, 3>>();
  return Eigen::Vector3f(values.data());
}

TEST_CASE("A session's JSON holds every sphere as it was published", "[inspection_json]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  CHECK(session_json(session)["scene"]["snapshot"].is_null());
  writer.publish_next();
  CHECK_FALSE(session_json(session)["scene"]["snapshot"]["spheres"][0].contains("history"));
  const Json first = session_json(session, {.history = true});
  CHECK(first["scene"]["snapshot"]["spheres"][0]["history"] == Json::array());
  for (int n = 2; n <= 5; ++n) writer.publish_next();

  const Json json = session_json(session, {.history = true});

  CHECK(json["session"] == session.name());
  CHECK(json["tool"].is_null());
  CHECK(json["scene"]["state"] == "alive");
  CHECK(json["scene"]["header"]["latest"] == 5);
  const Json& fixed = json["scene"]["fixed"];
  CHECK(fixed["name"] == "small");
  CHECK(fixed["materials"].size() == 2);
  CHECK(fixed["planes"][0]["body"] == 5);
  CHECK(fixed["tool_spheres"].size() == 2);
  CHECK(fixed["static_spheres"].size() == 10);
  const Json& snapshot = json["scene"]["snapshot"];
  CHECK(snapshot["snapshot_id"] == 5);
  CHECK(snapshot["state_time_ns"] ==
        Json({5 * publication::kPeriod_ns, 4 * publication::kPeriod_ns}));
  CHECK(snapshot["contacts"] == 5);
  REQUIRE(snapshot["spheres"].size() == publication::kMovingSpheres);
  for (std::size_t i = 0; i < publication::kMovingSpheres; ++i) {
    const Json& sphere = snapshot["spheres"][i];
    CHECK(sphere["body"] == i);
    CHECK(sphere["material"] == 1);
    REQUIRE(sphere["history"].size() == 1);
    for (std::uint64_t age = 0; age < 2; ++age) {
      const Json& state = age == 0 ? sphere : sphere["history"][age - 1];
      CHECK(vector(state["position_m"]) ==
            publication::SmallSceneWriter::position_m(i, 5 - age).cast<float>());
      CHECK(vector(state["velocity_m_s"]) ==
            publication::SmallSceneWriter::velocity_m_s(i, 5 - age).cast<float>());
    }
  }
}

TEST_CASE("A session's JSON tells its fields, and where those that move are", "[inspection_json]") {
  const publication::TestSession session;
  const publication::StaticScene scene = publication::field_scene();
  publication::SceneWriter writer(session.name(), scene, 0, publication::kPeriod_ns,
                                  proto::Clock::kVirtual, 0);
  const collision::VoxelGrid snapshot(sizeof(proto::SnapshotHeader), 0);
  for (std::uint64_t n = 1; n <= 2; ++n)
    writer.publish(snapshot, {.state_ns = n * publication::kPeriod_ns},
                   std::array{publication::field_record(1, n), publication::field_record(2, n)});

  const Json json = session_json(session, {.history = true});
  const Json& fields = json["scene"]["fixed"]["fields"];
  REQUIRE(fields.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(fields[i]["body"] == scene.fields[i].body.body);
    CHECK(fields[i]["bytes"] == scene.fields[i].field->bytes());
    CHECK(fields[i]["bricks"] == scene.fields[i].field->shape().bricks);
    CHECK(fields[i]["moves"] == (i > 0));
    CHECK(fields[i]["rest"].is_null() == (i > 0));
  }
  CHECK(fields[1]["cell_m"].get<double>() == Approx(0.0019));
  CHECK(fields[1]["has_stiffness"] == true);
  CHECK(vector(fields[0]["rest"]["position_m"]) == Eigen::Vector3f(0.2F, -0.1F, 0.05F));
  const Json& moving = json["scene"]["snapshot"]["fields"];
  REQUIRE(moving.size() == 2);
  for (std::uint32_t i = 0; i < 2; ++i) {
    const proto::FieldRecord given = publication::field_record(i + 1, 2);
    CHECK(vector(moving[i]["position_m"]) == Eigen::Vector3f(given.history[0].position_m.data()));
    CHECK(moving[i]["history"].size() == 1);
    CHECK(vector(moving[i]["history"][0]["position_m"]) ==
          Eigen::Vector3f(given.history[1].position_m.data()));
  }
}

TEST_CASE("Numbers are written as people wrote them", "[inspection_json]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const Json json = session_json(session);
  CHECK(json["scene"]["snapshot"]["spheres"][0]["radius_m"].dump() == "0.01");
  CHECK(json["scene"]["fixed"]["planes"][0]["offset_m"].dump() == "-0.1");
}

TEST_CASE("The spheres of a JSON can be limited and it says how many it left out",
          "[inspection_json]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const Json json = session_json(session, {.max_spheres = 3});
  CHECK(json["scene"]["snapshot"]["spheres"].size() == 3);
  CHECK(json["scene"]["snapshot"]["spheres_left_out"] == publication::kMovingSpheres - 3);
  CHECK(json["scene"]["fixed"]["static_spheres"].size() == 3);
  CHECK(json["scene"]["fixed"]["static_spheres_left_out"] == 7);
}

TEST_CASE("What is no number is null in JSON", "[inspection_json]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  publication::ToolWriter tool_writer(session.name(), 1'000'000, proto::Clock::kVirtual, 0);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  proto::ToolState state{};
  state.position_m = {kNaN, 1.0, INFINITY};
  tool_writer.publish(state);
  const publication::Tampering memory(session.path(kScene));
  const auto& header = memory.at<proto::SegmentHeader>(0);
  const reading::ObservedSegment scene = reading::observe({session.name(), kScene});
  const reading::ObservedSegment tool = reading::observe({session.name(), kTool});
  const auto first = header.slot_offset[1] + sizeof(proto::SlotHeader) +
                     (sizeof(proto::SnapshotHeader) + 63) / 64 * 64;
  auto& sphere = memory.at<proto::SphereRecord>(first);
  REQUIRE(sphere.radius_m == 0.01F);
  sphere.newest.position_m = {std::numeric_limits<float>::quiet_NaN(), -INFINITY, 0.5F};

  const Json json = Json::parse(text_of(json_of(session.name(), &scene, &tool, {})));

  CHECK(json["scene"]["snapshot"]["spheres"][0]["position_m"] == Json({nullptr, nullptr, 0.5}));
  CHECK(json["tool"]["latest_state"]["position_m"] == Json({nullptr, 1.0, nullptr}));
  CHECK_NOTHROW(detail_of(json_of(session.name(), &scene, &tool, {})));
}

TEST_CASE("Strings of any bytes make valid JSON", "[inspection_json]") {
  const publication::TestSession session;
  const publication::SmallSceneWriter writer(session);
  const publication::Tampering memory(session.path(kScene));
  auto& fixed = memory.at<proto::SceneHeader>(sizeof(proto::SegmentHeader));
  fixed.name = {'\xFF', '\x1B', '[', '2', 'J', '"', '\n', '\0'};
  const Json json = session_json(session);
  CHECK(json["scene"]["fixed"]["name"].get<std::string>().find("\x1B[2J\"\n") != std::string::npos);

  reading::SegmentSummary summary;
  summary.file.session = "\x80\xFF";
  CHECK(Json::parse(text_of(json_of(std::span(&summary, 1)))).size() == 1);
}

TEST_CASE("Whatever a writer wrote into a snapshot the JSON is valid and bounded",
          "[inspection_json]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const publication::Tampering memory(session.path(kScene));
  const auto& header = memory.at<proto::SegmentHeader>(0);
  const std::size_t words = header.payload_bytes / 8;
  auto* payload = &memory.at<std::uint64_t>(header.slot_offset[1] + sizeof(proto::SlotHeader));
  const std::vector<std::uint64_t> sound(payload, payload + words);
  std::mt19937_64 random(1);
  std::size_t with_spheres = 0;
  for (int round = 0; round < 300; ++round) {
    // A few words of the header or any, one bit or all of them.
    const std::size_t range = round % 2 == 0 ? sizeof(proto::SnapshotHeader) / 8 : words;
    for (int i = 0; i < 1 + round % 20; ++i) {
      const std::uint64_t bits = random();
      payload[random() % range] ^= round % 3 == 0 ? std::uint64_t{1} << (bits % 64) : bits;
    }
    payload[0] = sound[0];  // under another number it is not believed
    const Json json = session_json(session, {.history = true});
    const Json& spheres = json["scene"]["snapshot"]["spheres"];
    REQUIRE(spheres.size() <= publication::kMovingSpheres);
    if (!spheres.empty()) ++with_spheres;
    const reading::ObservedSegment scene = reading::observe({session.name(), kScene});
    REQUIRE(detail_of(json_of(session.name(), &scene, nullptr, {.max_spheres = 0})).size() < 20000);
    if (round % 4 == 3) std::copy(sound.begin(), sound.end(), payload);
  }
  CHECK(with_spheres > 50);
}

TEST_CASE("A listing as JSON has an object for each row and null for what is not known",
          "[inspection_json]") {
  reading::SegmentSummary refused;
  refused.file = {"a", kTool};
  refused.state = reading::SegmentState::kRefused;
  refused.refusal = "why";
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const std::array summaries{refused, reading::observe({session.name(), kScene}).summary};

  const Json json = Json::parse(text_of(json_of(summaries)));

  REQUIRE(json.size() == 2);
  CHECK(json[0]["state"] == "refused");
  CHECK(json[0]["refusal"] == "why");
  CHECK(json[0]["declared_rate_hz"].is_null());
  CHECK(json[1]["refusal"].is_null());
  CHECK(json[1]["moving_spheres"] == publication::kMovingSpheres);
  CHECK(json[1]["declared_rate_hz"].get<double>() == Approx(1e9 / publication::kPeriod_ns));
  CHECK(json[1]["age_s"].is_null());
}

}  // namespace
}  // namespace stillgrid::segment_inspect::inspection_json_test
