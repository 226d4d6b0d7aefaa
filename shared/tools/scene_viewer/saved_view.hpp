#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "shared/tools/scene_viewer/view_file.hpp"
#include "shared/tools/scene_viewer/view_source.hpp"

namespace stillgrid::scene_viewer {

/// What scene_viewer --save kept of a session.
class SavedView final : public ViewSource {
 public:
  /// Throws std::runtime_error, one line, where that is no view or has no sound frame.
  explicit SavedView(const std::filesystem::path& file);

  [[nodiscard]] ViewStatus status() const override;
  [[nodiscard]] Message scene(std::optional<std::string_view> key) const override;
  [[nodiscard]] Message frame(std::optional<std::uint64_t> number) const override;
  [[nodiscard]] std::string ticks(std::uint64_t from, std::size_t most) const override;

 private:
  ViewReader reader_;
  std::vector<std::pair<std::string, Message>> scenes_;  // by key
  ViewStatus status_;
};

}  // namespace stillgrid::scene_viewer
