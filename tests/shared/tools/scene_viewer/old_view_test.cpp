#include "shared/tools/scene_viewer/old_view.hpp"

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "shared/tools/scene_viewer/saved_view.hpp"
#include "shared/tools/scene_viewer/view_file.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::scene_viewer::old_view_test {
namespace {

using Json = nlohmann::json;

// As version 1 wrote them, every key; the second of each as today's viewer would.
constexpr const char* kOldScene = R"({"session":"image","source":"session","scene_key":"cut",
"flags":["contended","cut","swept"],"name":"generation",
"materials":[{"stiffness_N_m":300.0,"damping_N_s_m":0.5,"friction":0.3,"slip_speed_m_s":0.01}],
"planes":[{"normal":[0.0,0.0,1.0],"offset_m":0.0,"material":0,"body":0}],
"tool_spheres":[{"position_m":[0.0,0.0,0.0],"radius_m":0.005}],"tool_slip_speed_m_s":0.01,
"device":{"position_m":[0.0,0.0,0.0],"orientation_xyzw":[0.0,0.0,0.0,1.0],"scale":1.0},
"static_grid":{"spheres":0,"levels":[{"voxel_m":0.02,"reach_m":0.01,"cells":64}]},
"period_s":0.03,"tick_period_s":0.001,
"spheres":{"count":1,"static_count":0,"radius_m":[0.01],"body":[1],"material":[0],
"static_position_m":[]},"static_voxels":{"box_m":[],"count":[]},"surfaces":null})";
constexpr const char* kScene = R"({"session":"image","source":"view","scene_key":"cut",
"flags":["contended","truncated","swept"],"name":"generation",
"materials":[{"stiffness_N_per_m":300.0,"damping_N_s_per_m":0.5,"friction":0.3,
"slip_speed_m_s":0.01}],
"planes":[{"normal":[0.0,0.0,1.0],"offset_m":0.0,"material":0,"body":0}],
"tool_spheres":[{"position_m":[0.0,0.0,0.0],"radius_m":0.005}],"tool_slip_speed_m_s":0.01,
"device":{"position_m":[0.0,0.0,0.0],"orientation_xyzw":[0.0,0.0,0.0,1.0],"scale":1.0},
"static_grid":{"spheres":0,"levels":[{"voxel_m":0.02,"bounding_radius_m":0.01,"cells":64}]},
"period_s":0.03,"tick_period_s":0.001,
"spheres":{"count":1,"static_count":0,"radius_m":[0.01],"body":[1],"material":[0],
"static_position_m":[]},"static_voxels":{"box_m":[],"count":[]},"surfaces":null})";
constexpr const char* kOldFrame = R"({"frame":7,"time_s":1.5,"scene_key":"cut","sim":"alive",
"hand":"alive","generation":9,"image":{"state_time_s":1.47,"publish_time_s":1.48,
"tool_time_s":1.46,"age_s":0.03,"step_ms":4.0,"contacts":2,"foresight_ms":30.0,"history_count":4},
"grid":{"levels":[{"voxel_m":0.02,"reach_m":0.01,"cells":64}]},
"display":{"generation":9,"alpha":0.5,"weights":[0.5,0.5,0.0,0.0],"velocity_s":[0.0,0.0,0.0,0.0],
"drift_s":0.01,"answer_lag_s":0.02,"answer_N":0.25,"shift_m":[0.0,0.0,0.0],"age_s":0.02},
"tool":{"time_s":1.5,"tick":1500,"position_m":[0.0,0.0,0.0],
"orientation_xyzw":[0.0,0.0,0.0,1.0],"velocity_m_s":[0.0,0.0,0.0],"force_N":[0.0,0.0,1.0],
"torque_N_m":[0.0,0.0,0.0],"contacts":1,"age_s":0.02,"flags":["cut","swept"]},
"ticks":{"seen":1000,"expected":1000,"per_s":1000.0,"missed":0,
"tick_us":{"p50":20.0,"p99":30.0,"p999":40.0},"wake_us":{"p50":2.0,"p99":3.0,"p999":4.0}},
"arrays":[{"name":"newest","type":"f32","count":0},{"name":"previous","type":"f32","count":0},
{"name":"displayed","type":"f32","count":0},{"name":"voxels","type":"f32","count":4},
{"name":"voxel_count","type":"u32","count":1}]})";
constexpr const char* kFrame = R"({"frame":7,"time_s":1.5,"scene_key":"cut","sim":"alive",
"hand":"alive","snapshot_id":9,"snapshot":{"state_time_s":1.47,"publish_time_s":1.48,
"tool_time_s":1.46,"age_s":0.03,"step_ms":4.0,"contacts":2,"prediction_ms":30.0,
"history_count":4},"grid":{"levels":[{"voxel_m":0.02,"bounding_radius_m":0.01,"cells":64}]},
"display":{"snapshot_id":9,"alpha":0.5,"weights":[0.5,0.5,0.0,0.0],
"velocity_s":[0.0,0.0,0.0,0.0],"prediction_s":0.01,"compliance_lag_s":0.02,"force_change_N":0.25,
"shift_m":[0.0,0.0,0.0],"age_s":0.02},
"tool":{"time_s":1.5,"tick":1500,"position_m":[0.0,0.0,0.0],
"orientation_xyzw":[0.0,0.0,0.0,1.0],"velocity_m_s":[0.0,0.0,0.0],"force_N":[0.0,0.0,1.0],
"torque_N_m":[0.0,0.0,0.0],"contacts":1,"age_s":0.02,"flags":["truncated","swept"]},
"ticks":{"seen":1000,"expected":1000,"per_s":1000.0,"missed":0,
"tick_us":{"p50":20.0,"p99":30.0,"p999":40.0},"wake_us":{"p50":2.0,"p99":3.0,"p999":4.0}},
"arrays":[{"name":"newest","type":"f32","count":0},{"name":"previous","type":"f32","count":0},
{"name":"displayed","type":"f32","count":0},{"name":"voxels","type":"f32","count":4},
{"name":"voxel_count","type":"u32","count":1}]})";
const std::string kArrays = "sixteen bytes...and4";

std::string message_of(std::string head) {
  head.resize((head.size() + 3) / 4 * 4, ' ');
  const auto length = static_cast<std::uint32_t>(head.size());
  return std::string(reinterpret_cast<const char*>(&length), sizeof length) + head + kArrays;
}

std::filesystem::path old_view(const tests::TestFolder& folder, const std::string& scene,
                               const std::string& frame) {
  const auto file = folder.path / "old.view";
  {
    ViewWriter writer(file);
    writer.add(ViewRecord::kScene, scene);
    writer.add(ViewRecord::kFrame, frame);
  }
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(8).put(1);
  return file;
}

TEST_CASE("A saved view of version 1 is shown as one of today, each key and flag", "[old_view]") {
  const tests::TestFolder folder;
  const SavedView view(old_view(folder, kOldScene, message_of(kOldFrame)));
  CHECK(Json::parse(*view.scene("cut")) == Json::parse(kScene));
  const std::string frame = *view.frame(1);
  std::uint32_t length = 0;
  std::memcpy(&length, frame.data(), sizeof length);
  CHECK(length % 4 == 0);
  CHECK(Json::parse(frame.substr(4, length)) == Json::parse(kFrame));
  CHECK(frame.substr(4 + length) == kArrays);
}

TEST_CASE("A saved view that nests without end does no harm in either version", "[old_view]") {
  const tests::TestFolder folder;
  std::string deep(2'000'000, '[');
  deep += std::string(2'000'000, ']');
  const auto with = [&](const std::string& text) {
    return text.substr(0, text.size() - 1) + ",\"more\":" + deep + "}";
  };
  const auto file = old_view(folder, with(kOldScene), message_of(with(kOldFrame)));
  CHECK(SavedView(file).frame(1));
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(8).put(2);
  CHECK(SavedView(file).frame(1));
}

TEST_CASE("What is no message of a saved view of version 1 stays as it is", "[old_view]") {
  for (const std::string damaged : {"", "abc", "\xFF\xFF\xFF\xFF", "[1, 2"}) {
    CHECK(frame_of_version_1(damaged) == damaged);
    CHECK(scene_of_version_1(damaged) == damaged);
  }
}

}  // namespace
}  // namespace stillgrid::scene_viewer::old_view_test
