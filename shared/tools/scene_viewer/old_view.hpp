#pragma once

#include <string>

namespace stillgrid::scene_viewer {

/// A message of a saved view of version 1 with the keys and flags of today
/// (shared/files/old_names.hpp), of a scene and of a frame; as it is where it is no such message.
/// Bytes of strangers do no harm. Thread: any.
[[nodiscard]] std::string scene_of_version_1(const std::string& message);
[[nodiscard]] std::string frame_of_version_1(const std::string& message);

}  // namespace stillgrid::scene_viewer
