#include "shared/tools/scene_viewer/scene_message.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <vector>

#include "shared/reading/snapshot.hpp"
#include "tests/shared/publication/small_scene.hpp"
#include "tests/shared/publication/tampering.hpp"
#include "tests/shared/tools/scene_viewer/refusal_line.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::scene_viewer::scene_message_test {
namespace {

constexpr const char* kSurfaces =
    R"({"spheres": 17, "bodies": [{"body": 0, "vertices": [{"spheres": [0, 16], "weights": [0.5, 0.5]},
    {"spheres": [1], "weights": [1]}], "lines": [[0, 1]]},
    {"body": 1, "vertices": [{"spheres": [], "weights": [], "still_m": [0.25, 1, 2]}],
    "triangles": []}]})";

/// How many of the points lie in the i-th box of its centre and edge.
int spheres_within(const nlohmann::json& box_m, std::size_t i, const nlohmann::json& position_m) {
  int count = 0;
  for (std::size_t point = 0; point < position_m.size(); point += 3) {
    bool is_within = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      is_within = is_within && std::abs(position_m[point + axis].get<double>() -
                                        box_m[4 * i + axis].get<double>()) <=
                                   0.5001 * box_m[4 * i + 3].get<double>();
    count += is_within ? 1 : 0;
  }
  return count;
}

TEST_CASE("A scene's message numbers all spheres, moving ones first", "[scene_message]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const publication::SceneView view(*publication::SegmentReader::open(
      session.name(), proto::SegmentKind::kScene, proto::kSceneLayoutHash));
  const tests::TestFolder folder;
  const Surfaces surfaces = read_surfaces(folder.write("s.json", kSurfaces));
  const auto moving = reading::read_snapshot(view, 1000)->spheres;

  const auto json = nlohmann::json::parse(
      scene_message(view, session.name(), "key", moving, surfaces, 1'000'000));

  CHECK(json["spheres"]["count"] == publication::kMovingSpheres);
  CHECK(json["spheres"]["static_count"] == 10);
  CHECK(json["spheres"]["radius_m"].size() == 17);
  CHECK(json["spheres"]["radius_m"][6] == 0.01);
  CHECK(json["spheres"]["radius_m"][7] == 0.008);
  CHECK(json["spheres"]["static_position_m"].size() == 30);
  CHECK(json["spheres"]["static_position_m"][3] == 0.01);
  const auto& voxels = json["static_voxels"];
  CHECK(voxels["box_m"].size() == 4 * voxels["count"].size());
  const auto counts = voxels["count"].get<std::vector<int>>();
  CHECK(std::accumulate(counts.begin(), counts.end(), 0) == 10);
  const double voxel_m = json["static_grid"]["levels"][0]["voxel_m"];
  const auto& box_m = voxels["box_m"];
  for (std::size_t i = 0; i < counts.size(); ++i) {
    CHECK(box_m[4 * i + 3] == voxel_m);
    CHECK(spheres_within(box_m, i, json["spheres"]["static_position_m"]) == counts[i]);
  }
  CHECK(json["planes"].size() == 1);
  CHECK(json["tool_spheres"].size() == 2);
  CHECK(json["tick_period_s"] == 1e-3);
  CHECK(json["flags"][2] == "faded");
  CHECK(json["surfaces"]["bodies"].size() == 2);
}

TEST_CASE("Surfaces of a scene with another number of spheres are left out", "[scene_message]") {
  const publication::TestSession session;
  const publication::SmallSceneWriter writer(session);
  const publication::SceneView view(*publication::SegmentReader::open(
      session.name(), proto::SegmentKind::kScene, proto::kSceneLayoutHash));
  const tests::TestFolder folder;
  const Surfaces surfaces = read_surfaces(folder.write("s.json", kSurfaces));
  const auto json =
      nlohmann::json::parse(scene_message(view, session.name(), "key", {}, surfaces, 0));
  CHECK(json["surfaces"].is_null());
  CHECK(json["tick_period_s"].is_null());
}

TEST_CASE("Surfaces of a scene with another name are left out", "[scene_message]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const publication::SceneView view(*publication::SegmentReader::open(
      session.name(), proto::SegmentKind::kScene, proto::kSceneLayoutHash));
  const auto moving = reading::read_snapshot(view, 1000)->spheres;
  Surfaces surfaces{.text = "{}", .scene = view.scene().name.data(), .sphere_count = 17};
  const auto are_told = [&] {
    return !nlohmann::json::parse(scene_message(view, "s", "k", moving, surfaces, 0))["surfaces"]
                .is_null();
  };
  CHECK(are_told());
  surfaces.scene = "another";
  CHECK_FALSE(are_told());
  surfaces.scene = "";  // a file that does not tell
  CHECK(are_told());
}

TEST_CASE("Surfaces that name what is not there are refused in one line", "[scene_message]") {
  const tests::TestFolder folder;
  const auto refusal = [&](std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    const auto file = folder.write("bad.json", text);
    return refusal_line([&] { static_cast<void>(read_surfaces(file)); });
  };
  CHECK(refusal(kSurfaces, "17", "16").find("bodies[0]") != std::string::npos);
  CHECK(refusal(kSurfaces, "[[0, 1]]", "[[0, 2]]").find("bodies[0]") != std::string::npos);
  CHECK(refusal(kSurfaces, "[[0, 1]]", "[[0]]").find("bodies[0]") != std::string::npos);
  CHECK(refusal(kSurfaces, "[0.5, 0.5]", "[1.0]").find("bodies[0]") != std::string::npos);
  CHECK(refusal(kSurfaces, "\"body\"", "\"bodi\"").find("bodies[0]") != std::string::npos);
  CHECK(refusal(kSurfaces, "\"bodies\"", "\"boards\"").find("a list \"bodies\"") !=
        std::string::npos);
  CHECK(refusal(kSurfaces, "{\"spheres\": 17", "{").find("expected JSON") != std::string::npos);
  CHECK(refusal(kSurfaces, "[0.25, 1, 2]", "[0.25, 1]").find("bodies[1]") != std::string::npos);
  CHECK(refusal(kSurfaces, "0.25", "\"a\"").find("bodies[1]") != std::string::npos);
  CHECK(refusal(kSurfaces, "\"bodies\"", "\"names\": [\"a\", 1], \"bodies\"").find("\"names\"") !=
        std::string::npos);
  CHECK(refusal(kSurfaces, "\"bodies\"", "\"names\": [\"a\"], \"bodies\"").empty());
  CHECK(refusal(kSurfaces, "17", "17").empty());
  CHECK(refusal_line([&] { static_cast<void>(read_surfaces("/nowhere.json")); }) ==
        "/nowhere.json: cannot be read: No such file or directory");
  CHECK(refusal_line([&] { static_cast<void>(read_surfaces(folder.path)); }) ==
        folder.path.string() + ": cannot be read: expected a regular file");
}

TEST_CASE("Whatever a writer published, its scene can be kept and opened again",
          "[scene_message]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const publication::SceneView view(*publication::SegmentReader::open(
      session.name(), proto::SegmentKind::kScene, proto::kSceneLayoutHash));
  const publication::Tampering memory(session.path(proto::SegmentKind::kScene));
  auto* const words = &memory.at<std::uint64_t>(view.scene().static_offset);
  const std::size_t count = (view.reader().fixed_bytes() - view.scene().static_offset) / 8;
  std::mt19937_64 random(1);
  std::size_t not_finite = 0;
  for (int round = 0; round < 300; ++round) {
    for (int i = 0; i < 1 + round % 20; ++i)
      words[random() % count] = round % 2 == 0 ? ~std::uint64_t{0} << (random() % 64) : random();
    std::vector<proto::SphereRecord> moving(3);
    moving[0].radius_m = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    moving[1].radius_m = std::numeric_limits<float>::quiet_NaN();
    const std::string message = scene_message(view, "s", "k", moving, {}, 1'000'000);
    REQUIRE(saved_scene(message));
    const auto json = nlohmann::json::parse(message);
    for (const auto& x : json["spheres"]["static_position_m"]) not_finite += x.is_null() ? 1U : 0U;
  }
  CHECK(not_finite > 100);
}

TEST_CASE("A saved scene is one whose spheres and surfaces are whole", "[scene_message]") {
  const std::string scene =
      R"({"scene_key": "k", "spheres": {"count": 1, "static_count": 1, "radius_m": [1, 1],
      "body": [0, 1], "material": [0, 0], "static_position_m": [0, 0, 0]}, "static_grid": {"levels": [{"voxel_m": 1}]},
      "static_voxels": {"box_m": [0, 0, 0, 1], "count": [1]},
      "surfaces": {"spheres": 2,
      "bodies": [{"body": 0, "vertices": [{"spheres": [1], "weights": [1]}], "lines": [[0, 0]]}]}})";
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = scene;
    return saved_scene(text.replace(text.find(from), from.size(), to));
  };
  REQUIRE(saved_scene(scene));
  CHECK(saved_scene(scene)->key == "k");
  CHECK_FALSE(with(R"("spheres": [1])", R"("spheres": [2])"));
  CHECK_FALSE(with(R"("surfaces": {)", R"("surface": {)"));
  CHECK_FALSE(with("[1, 1]", "[1]"));
  CHECK_FALSE(with("[1, 1]", R"([1, "a"])"));
  CHECK_FALSE(with("[0, 1]", "[0, -1]"));
  CHECK_FALSE(with("[0, 0, 0]", "[0, 0]"));
  CHECK_FALSE(with(R"("static_count": 1)", R"("static_count": 1e30)"));
  CHECK_FALSE(with(R"("count": 1,)", ""));
  CHECK_FALSE(with("[0, 0, 0, 1]", "[0, 0, 0]"));
  CHECK_FALSE(with(R"("count": [1])", R"("count": [-1])"));
  CHECK_FALSE(with(R"("count": [1])", R"("count": 1)"));
  CHECK_FALSE(with("static_voxels", "voxels"));
  CHECK_FALSE(with(R"([{"voxel_m": 1}])", "5"));
  CHECK_FALSE(with(R"({"voxel_m": 1})", "null"));
  CHECK_FALSE(with(R"({"levels": [{"voxel_m": 1}]})", "1"));
}

}  // namespace
}  // namespace stillgrid::scene_viewer::scene_message_test
