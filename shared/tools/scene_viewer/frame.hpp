#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/tool_segment.hpp"
#include "shared/reading/segment_follower.hpp"
#include "shared/reading/snapshot.hpp"
#include "shared/tools/scene_viewer/tick_history.hpp"

namespace stillgrid::scene_viewer {

/// Where a session's clock stands on the axis of the frames' times.
struct TimeAxis {
  std::uint64_t zero_ns = 0;

  [[nodiscard]] double seconds(std::uint64_t time_ns) const noexcept {
    return time_ns >= zero_ns ? static_cast<double>(time_ns - zero_ns) * 1e-9
                              : -static_cast<double>(zero_ns - time_ns) * 1e-9;
  }
};

/// A hand of the session besides the one that is shown in full.
struct OtherHand {
  std::string name;
  proto::ToolState tool;  // checked, and its figures too
  std::vector<proto::ToolSphere> spheres;
};

/// One look at a session.
struct Frame {
  std::uint64_t number = 0;
  std::uint64_t now_ns = 0;  // on the session's clock
  TimeAxis axis;
  std::string scene_key;
  std::uint64_t scene_epoch = 0;
  reading::Life sim = reading::Life::kAbsent, hand = reading::Life::kAbsent;
  std::optional<proto::RelayFigures> sim_relay, hand_relay;  // that write the segments
  std::optional<reading::SceneSnapshot> snapshot;
  std::optional<proto::ToolState> tool;  // checked, and its figures too
  TickSummary ticks;
  std::vector<OtherHand> others;
};

/// The answer of /api/frame: docs/viewer.md.
[[nodiscard]] std::string frame_message(const Frame& frame);

}  // namespace stillgrid::scene_viewer
