#include "shared/reading/segment_follower.hpp"

#include <utility>

#include "shared/publication/relay_figures.hpp"

namespace stillgrid::reading {

std::string_view name_of(Life life) noexcept {
  switch (life) {
    case Life::kAlive:
      return "alive";
    case Life::kSilent:
      return "silent";
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
  if (!id || is_ours()) {
    refused_ = {};
  } else {
    ObservedSegment found = observe(file_);
    refused_ = found.summary;
    if (found.reader() != nullptr) {
      segment_.reset();  // neither moved nor assigned: views hold their place
      segment_.emplace(std::move(found));
    }
  }
  relay_ = segment_ ? publication::load_relay_figures(segment_->reader()->live()) : std::nullopt;
  if (segment_ && segment_->reader()->writer_alive())
    life_ = relay_ && relay_->connected == 0 ? Life::kSilent : Life::kAlive;
  else
    life_ = is_ours() ? Life::kDead : Life::kAbsent;
}

const publication::SceneView* SegmentFollower::scene() const noexcept {
  return segment_ && segment_->scene ? &*segment_->scene : nullptr;
}

const publication::ToolView* SegmentFollower::tool() const noexcept {
  return segment_ && segment_->tool ? &*segment_->tool : nullptr;
}

}  // namespace stillgrid::reading
