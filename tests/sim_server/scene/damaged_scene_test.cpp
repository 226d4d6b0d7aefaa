#include <catch2/catch.hpp>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sim_server/scene/scene_file.hpp"
#include "tests/sim_server/scene/full_scene.hpp"
#include "tests/sim_server/scene/temporary_scene.hpp"

namespace stillgrid::scene::damaged_scene_test {

TEST_CASE("A scene cut off at any byte loads or is refused in one line", "[scene_file]") {
  const TemporaryScene file("");
  for (std::size_t length = 0; length < kFullScene.size(); ++length) {
    file.write(kFullScene.substr(0, length));
    try {
      (void)load_scene(file.path());
    } catch (const toml::SceneError& error) {
      const std::string_view line = error.what();
      if (!line.starts_with(file.path().string() + ":") ||
          line.find('\n') != std::string_view::npos) {
        FAIL("cut at byte " << length << ": " << line);
      }
    }
  }
  SUCCEED();
}

TEST_CASE("A scene with any byte replaced loads or is refused", "[scene_file]") {
  const TemporaryScene file("");
  for (std::size_t place = 0; place < kFullScene.size(); ++place) {
    std::string text(kFullScene);
    text[place] = "\0\n\"[]{}=-.9e\xff#"[place % 14];
    file.write(text);
    try {
      (void)load_scene(file.path());
    } catch (const std::runtime_error& refusal) {
      if (!std::string_view(refusal.what()).starts_with(file.path().string() + ":"))
        FAIL("byte " << place << ": " << refusal.what());
    }
  }
  SUCCEED();
}

}  // namespace stillgrid::scene::damaged_scene_test
