#include "tests/sim_server/scene/temporary_scene.hpp"

#include <unistd.h>

#include <fstream>

namespace stillgrid::scene {

TemporaryScene::TemporaryScene(std::string_view text) {
  static int count = 0;
  path_ = std::filesystem::temp_directory_path() /
          ("stillgrid_scene_" + std::to_string(getpid()) + "_" + std::to_string(count++) + ".toml");
  write(text);
}

TemporaryScene::~TemporaryScene() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void TemporaryScene::write(std::string_view text) const {
  std::ofstream stream(path_, std::ios::binary);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
}

SceneDescription scene_of(std::string_view text) {
  return load_scene(TemporaryScene(text).path());
}

std::string refusal_of(std::string_view text) {
  const TemporaryScene scene(text);
  try {
    (void)load_scene(scene.path());
  } catch (const toml::SceneError& error) {
    const std::string file = scene.path().string() + ":";
    const std::string line = error.what();
    return line.starts_with(file) ? line.substr(file.size()) : "names no file: " + line;
  }
  return "";
}

}  // namespace stillgrid::scene
