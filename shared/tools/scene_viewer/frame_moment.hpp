#pragma once

#include <optional>
#include <string>

namespace stillgrid::scene_viewer {

/// When a frame was, and of which scene.
struct FrameMoment {
  double time_s = 0.0;
  std::string scene_key;
};

/// Of an answer of /api/frame that comes from a file; nothing if anything in it is not as
/// docs/viewer.md tells.
[[nodiscard]] std::optional<FrameMoment> moment_of(const std::string& frame_message);

}  // namespace stillgrid::scene_viewer
