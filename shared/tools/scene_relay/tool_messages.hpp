#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/publication/tool_segment.hpp"
#include "shared/tools/scene_relay/messages.hpp"

namespace stillgrid::scene_relay {

/// Returns about how many bytes a message takes.
[[nodiscard]] std::size_t message_bytes(const ToolMessage& message) noexcept;

/// Encodes the tool of this machine: a message has its state and the newest ticks of its path.
///
/// A tick of the path is in the messages of kRepeated_ticks ms, so it arrives unless all of them
/// are lost. They fill one packet of kPacket_bytes: a longer message would be lost more often, for
/// it is lost with any of its packets. Thread: one.
class ToolMessages {
 public:
  static constexpr std::uint64_t kRepeated_ticks = 12;
  /// A relay that was held up sends up to so many ticks at once.
  static constexpr std::uint64_t kMaxTicks = 64;
  /// Cyclone DDS makes packets of so many bytes.
  static constexpr std::size_t kPacket_bytes = 1344;

  explicit ToolMessages(std::uint64_t relay_id) : relay_id_(relay_id) {}

  /// Returns the message, valid until the next call. has_path: whether it has ticks of the path.
  [[nodiscard]] const ToolMessage& encode(const publication::ToolView& tool,
                                          const proto::ToolState& state, bool has_path);

 private:
  void add_path(const publication::PathView& path, std::uint64_t newest);

  std::uint64_t relay_id_;
  std::uint64_t number_ = 0;  // last message
  std::uint64_t newest_ = 0;  // tick in it
  std::vector<PathSample> path_;
  ToolMessage message_{};
};

}  // namespace stillgrid::scene_relay
