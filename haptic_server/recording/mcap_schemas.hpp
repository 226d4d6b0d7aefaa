#pragma once

#include <string>

namespace stillgrid::recording {

/// JSON schemas of the messages of an MCAP recording. Those of Foxglove
/// [https://docs.foxglove.dev/docs/sdk/schemas] are theirs in all but the descriptions.
[[nodiscard]] std::string tick_schema();
[[nodiscard]] std::string flags_schema();
[[nodiscard]] std::string frame_transform_schema();
[[nodiscard]] std::string scene_update_schema();

}  // namespace stillgrid::recording
