#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/publication/tool_segment.hpp"
#include "shared/tools/scene_relay/messages.hpp"

namespace stillgrid::scene_relay {

/// What a message takes, about; bytes.
[[nodiscard]] std::size_t message_bytes(const ToolMessage& message) noexcept;

/// The tool of this machine as messages: each tells its state and the newest ticks of its path.
///
/// A tick of the path is told in all messages of the next kRepeated_ticks - 1 ms too. So no tick is
/// missing unless all of these are lost. They fill one packet of kFragment_bytes: a longer message
/// would be lost more often, for it is lost with any of its packets. Thread: one.
class ToldTool {
 public:
  static constexpr std::uint64_t kRepeated_ticks = 12;
  /// A relay that was held up tells up to so many ticks at once.
  static constexpr std::uint64_t kMost_ticks = 64;
  /// Of Cyclone DDS's fragments, one to a packet.
  static constexpr std::size_t kFragment_bytes = 1344;

  explicit ToldTool(std::uint64_t relay_id) : relay_id_(relay_id) {}

  /// Returns the message, good until the next call. has_path: whether the path is told.
  [[nodiscard]] const ToolMessage& tell(const publication::ToolView& tool,
                                        const proto::ToolState& state, bool has_path);

 private:
  void tell_path(const publication::PathView& path, std::uint64_t newest);

  std::uint64_t relay_id_;
  std::uint64_t number_ = 0, told_ = 0;  // messages; the newest tick that was told
  std::vector<PathSample> path_;
  ToolMessage message_{};
};

}  // namespace stillgrid::scene_relay
