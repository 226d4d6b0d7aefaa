#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "shared/reading/observed_segment.hpp"

namespace stillgrid::reading {

/// Of the writer of a session's segment.
enum class Life {
  kAbsent,  // not come yet, or ended
  kAlive,
  kSilent,  // alive, but a relay whose other side is not heard
  kDead,    // killed: its segment stands
};
[[nodiscard]] std::string_view name_of(Life life) noexcept;

/// Keeps to the newest segment under a name while its writers come and go; the last one is kept
/// for reading after its writer's end. Thread: one.
class SegmentFollower {
 public:
  SegmentFollower(std::string session, proto::SegmentKind kind) : file_{std::move(session), kind} {}

  /// Looks at what stands under the name now. Some system calls.
  void look();

  [[nodiscard]] Life life() const noexcept { return life_; }
  /// What the relay tells that writes the segment; nothing where none does.
  [[nodiscard]] const std::optional<proto::RelayFigures>& relay() const noexcept { return relay_; }
  /// Why what stands there cannot be read, one line; empty where it can.
  [[nodiscard]] const std::string& refusal() const noexcept { return refused_.refusal; }
  /// What stands there and cannot be read; without a refusal nothing.
  [[nodiscard]] const SegmentSummary& refused() const noexcept { return refused_; }
  [[nodiscard]] const publication::SceneView* scene() const noexcept;
  [[nodiscard]] const publication::ToolView* tool() const noexcept;

 private:
  publication::SegmentFile file_;
  std::optional<ObservedSegment> segment_;
  Life life_ = Life::kAbsent;
  std::optional<proto::RelayFigures> relay_;
  SegmentSummary refused_;
};

}  // namespace stillgrid::reading
