#include "shared/tools/scene_viewer/segment_follower.hpp"

#include <utility>

namespace stillgrid::scene_viewer {

std::string_view name_of(Life life) noexcept {
  switch (life) {
    case Life::kAlive:
      return "alive";
    case Life::kDead:
      return "dead";
    case Life::kAbsent:
      break;
  }
  return "absent";
}

void SegmentFollower::look() {
  const auto id = publication::segment_id(file_.session, file_.kind);
  const auto is_ours = [&] { return segment_ && id && segment_->reader()->id() == *id; };
  if (id && !is_ours()) {
    segment_inspect::ObservedSegment found = segment_inspect::observe(file_);
    refusal_ = found.summary.refusal;
    if (found.reader() != nullptr) {
      segment_.reset();  // neither moved nor assigned: views hold their place
      segment_.emplace(std::move(found));
    }
  }
  if (segment_ && segment_->reader()->writer_alive())
    life_ = Life::kAlive;
  else
    life_ = is_ours() ? Life::kDead : Life::kAbsent;
}

const publication::SceneView* SegmentFollower::scene() const noexcept {
  return segment_ && segment_->scene ? &*segment_->scene : nullptr;
}

const publication::ToolView* SegmentFollower::tool() const noexcept {
  return segment_ && segment_->tool ? &*segment_->tool : nullptr;
}

}  // namespace stillgrid::scene_viewer
