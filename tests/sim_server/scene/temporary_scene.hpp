#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::scene {

/// A scene file that exists as long as this object does.
class TemporaryScene {
 public:
  explicit TemporaryScene(std::string_view text);
  ~TemporaryScene();
  TemporaryScene(const TemporaryScene&) = delete;
  TemporaryScene& operator=(const TemporaryScene&) = delete;

  /// Replaces what the file holds.
  void write(std::string_view text) const;
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
};

/// The scene that a text describes.
[[nodiscard]] SceneDescription scene_of(std::string_view text);

/// What the refusal of a text says after the file's name and a colon; empty if it loads.
[[nodiscard]] std::string refusal_of(std::string_view text);

}  // namespace stillgrid::scene
