#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "shared/publication/scene_segment.hpp"
#include "shared/publication/segment_watch.hpp"
#include "shared/publication/tool_segment.hpp"
#include "shared/rendering/local_copy.hpp"

namespace stillgrid::haptic_server {

using ToolWatch = publication::SegmentWatch<publication::ToolView>;

/// A hand's scene, its local copy, and the tools of the session's other hands as they come and go.
/// A scene without a model has neither copy nor such tools here.
class HandView : public publication::SceneView {
 public:
  /// In real time threads of its own look for the tools. Throws as SceneView.
  explicit HandView(publication::SegmentReader&& reader);

  /// The tools in the order of the hands, until the next call; null: away, and the own hand's.
  /// Thread: the one that ticks. Realtime: wait-free.
  [[nodiscard]] std::span<const publication::ToolView* const> look_at_tools() const noexcept;

  /// Returns the scene's copy, or null where its model is absent or refused. Thread: the one that
  /// ticks.
  [[nodiscard]] rendering::LocalCopy* local() const noexcept { return local_.get(); }

  /// Returns a watch for each hand; null: the own one. A lockstep run polls them itself.
  [[nodiscard]] std::span<const std::unique_ptr<ToolWatch>> watches() const noexcept {
    return watches_;
  }

 private:
  std::unique_ptr<rendering::LocalCopy> local_;
  std::vector<std::unique_ptr<ToolWatch>> watches_;          // one a hand
  mutable std::vector<const publication::ToolView*> tools_;  // the last look at them
};

}  // namespace stillgrid::haptic_server
