#include "shared/tools/scene_viewer/view_file.hpp"

#include <catch2/catch.hpp>
#include <fstream>

#include "shared/tools/scene_viewer/frame.hpp"
#include "shared/tools/scene_viewer/frame_moment.hpp"
#include "shared/tools/scene_viewer/saved_view.hpp"
#include "shared/tools/scene_viewer/scene_message.hpp"
#include "tests/shared/tools/scene_viewer/refusal_line.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::scene_viewer::view_file_test {
namespace {

TickSample tick_sample(std::uint64_t tick) {
  TickSample sample;
  sample.tick = tick;
  sample.age_s = static_cast<double>(tick);
  return sample;
}

/// Two scenes, three frames and 100 ticks.
std::filesystem::path small_view(const tests::TestFolder& folder) {
  const auto file = folder.path / "small.view";
  ViewWriter writer(file);
  std::vector<TickSample> ticks;
  writer.add(ViewRecord::kScene, R"({"scene_key": "a", "source": "session"})");
  for (std::uint64_t tick = 1; tick <= 50; ++tick) ticks.push_back(tick_sample(tick));
  writer.add(ticks);
  writer.add(ViewRecord::kFrame, "frame one");
  writer.add(ViewRecord::kFrame, "frame two");
  writer.add(ViewRecord::kScene, R"({"scene_key": "b", "source": "session"})");
  for (TickSample& sample : ticks) sample.tick += 50;
  writer.add(ticks);
  writer.add(ViewRecord::kFrame, "frame three");
  return file;
}

TEST_CASE("A saved view gives back what was put in", "[view_file]") {
  const tests::TestFolder folder;
  const ViewReader reader(small_view(folder));
  REQUIRE(reader.frame_count() == 3);
  REQUIRE(reader.scene_count() == 2);
  CHECK(reader.frame(1) == "frame two");
  CHECK(reader.scene(0)->find("\"a\"") != std::string::npos);
  const auto ticks = reader.ticks(45, 10);
  REQUIRE(ticks.size() == 10);
  for (std::size_t i = 0; i < ticks.size(); ++i) CHECK(ticks[i].tick == 45 + i);
  CHECK(reader.ticks(99, 1000).size() == 2);
  CHECK(reader.ticks(101, 1).empty());
}

TEST_CASE("A saved view that was cut anywhere reads up to its last whole record", "[view_file]") {
  const tests::TestFolder folder;
  const auto file = small_view(folder);
  std::size_t frames = 3;
  for (auto size = std::filesystem::file_size(file); size-- > 16;) {
    std::filesystem::resize_file(file, size);
    const ViewReader reader(file);
    CHECK(reader.frame_count() <= frames);
    frames = reader.frame_count();
    for (std::size_t i = 0; i < frames; ++i) CHECK(reader.frame(i)->substr(0, 5) == "frame");
  }
  CHECK(frames == 0);
  std::filesystem::resize_file(file, 15);
  CHECK(refusal_line([&] { ViewReader{file}; }).find("small.view: expected a view") !=
        std::string::npos);
}

TEST_CASE("A saved view that is cut while it is looked at gives no more of what is gone",
          "[view_file]") {
  const tests::TestFolder folder;
  const auto file = small_view(folder);
  const ViewReader reader(file);
  std::filesystem::resize_file(file, 100);
  CHECK_FALSE(reader.frame(2));
  CHECK(reader.ticks(60, 10).empty());
}

TEST_CASE("What is no saved view is refused in one line", "[view_file]") {
  const tests::TestFolder folder;
  CHECK(refusal_line([&] {
          ViewReader(folder.path / "none.view");
        }).find("none.view: No such file") != std::string::npos);
  CHECK(refusal_line([&] { ViewReader{folder.path}; }).find("expected a view") !=
        std::string::npos);
  const auto empty = folder.path / "empty.view";
  { const ViewWriter writer(empty); }
  CHECK(refusal_line([&] { SavedView{empty}; }).find("holds no frame") != std::string::npos);
  const auto odd = folder.path / "odd.view";
  {
    ViewWriter writer(odd);
    writer.add(ViewRecord::kScene, "[1, 2");
    writer.add(ViewRecord::kFrame, "\xFF\xFF\xFF\xFF");
  }
  CHECK(refusal_line([&] { SavedView{odd}; }).find("a scene that is none") != std::string::npos);
}

TEST_CASE("A record that claims more than the file holds ends the view", "[view_file]") {
  const tests::TestFolder folder;
  const auto file = small_view(folder);
  std::ofstream(file, std::ios::app | std::ios::binary)
      << std::string("\x02\0\0\0\xFF\xFF\xFF\xFF", 8) << "and some";
  CHECK(ViewReader(file).frame_count() == 3);
}

/// Of a scene, at that time.
std::string frame_at(double time_s, const std::string& scene_key) {
  Frame frame;
  frame.now_ns = static_cast<std::uint64_t>(1e9 * time_s);
  frame.scene_key = scene_key;
  frame.tool.emplace();
  return frame_message(frame);
}

/// Two scenes with a frame each, and between them one of the bytes given.
std::filesystem::path sound_view(const tests::TestFolder& folder, const std::string& between) {
  const auto file = folder.path / "sound.view";
  ViewWriter writer(file);
  writer.add(ViewRecord::kScene, empty_scene_message(ViewKind::kSession, "wall", "a"));
  writer.add(ViewRecord::kFrame, frame_at(0.5, "a"));
  writer.add(ViewRecord::kFrame, between);
  writer.add(ViewRecord::kScene, empty_scene_message(ViewKind::kSession, "wall", "b"));
  writer.add(ViewRecord::kFrame, frame_at(1.5, "b"));
  return file;
}

TEST_CASE("A saved view that nests without end does no harm", "[view_file]") {
  const tests::TestFolder folder;
  const std::string deep = std::string(2'000'000, '[') + std::string(2'000'000, ']');
  std::string scene = empty_scene_message(ViewKind::kSession, "wall", "a");
  scene.replace(scene.rfind('}'), 1, ",\"more\":" + deep + "}");
  const auto file = folder.path / "deep.view";
  {
    ViewWriter writer(file);
    writer.add(ViewRecord::kScene, scene);
    writer.add(ViewRecord::kFrame, frame_at(0.5, "a"));
  }
  CHECK(SavedView(file).scene("a")->size() < scene.size() / 2);
}

TEST_CASE("A saved view of another version is refused", "[view_file]") {
  const tests::TestFolder folder;
  const auto file = small_view(folder);
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(8).put(1);
  CHECK(refusal_line([&] { ViewReader{file}; }).ends_with("wrote, of version 2"));
}

TEST_CASE("A saved view finds the scene of each of its frames, and says that it is saved",
          "[view_file]") {
  const tests::TestFolder folder;
  const SavedView view(sound_view(folder, frame_at(1.0, "a")));
  CHECK(view.status().last_frame == 3);
  CHECK_FALSE(view.status().live);
  CHECK(view.status().now_s == 1.5);
  CHECK(view.scene("a")->find(R"("source":"view")") != std::string::npos);
  CHECK(view.scene(std::nullopt) == view.scene("b"));
  CHECK(view.scene("c") == nullptr);
  CHECK(*view.frame(2) == frame_at(1.0, "a"));
  CHECK(view.frame(0) == nullptr);
  CHECK(view.frame(4) == nullptr);
}

TEST_CASE("A frame of a saved view that is damaged is told, and the others shown", "[view_file]") {
  const tests::TestFolder folder;
  const std::string sound = frame_at(1.0, "a");
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = sound;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string damaged = GENERATE_COPY(
      std::string(), std::string("\xFF\xFF\xFF\xFF"), sound.substr(0, sound.size() - 4),
      sound + "four", with("\"position_m\"", "\"positiom_m\""),
      with("\"scene_key\":\"a\"", "\"scene_key\":123"), with("\"levels\":[]", "\"levels\":11"),
      with("\"count\":0", "\"count\":3"), with("f32", "f64"), with("\"absent\"", "\"alivee\""),
      with("\"p99\"", "\"p98\""), with("voxels", "vowels"));
  INFO(damaged);
  const SavedView view(sound_view(folder, damaged));
  CHECK(*view.frame(1) == frame_at(0.5, "a"));
  CHECK(refusal_line([&] { static_cast<void>(view.frame(2)); }) ==
        "frame 2 of this file is damaged");
  CHECK(view.frame(3));
}

TEST_CASE("A saved view whose last frame is damaged ends with the one before", "[view_file]") {
  const tests::TestFolder folder;
  const auto file = sound_view(folder, frame_at(1.0, "a"));
  std::fstream(file, std::ios::in | std::ios::out | std::ios::ate).seekp(-4, std::ios::end)
      << "{{{{";
  const SavedView view(file);
  CHECK(view.status().last_frame == 3);
  CHECK(view.status().now_s == 1.0);
  CHECK(view.status().scene_key == "a");
}

}  // namespace
}  // namespace stillgrid::scene_viewer::view_file_test
