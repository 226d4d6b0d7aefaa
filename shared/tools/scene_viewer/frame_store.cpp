#include "shared/tools/scene_viewer/frame_store.hpp"

#include <utility>

namespace stillgrid::scene_viewer {

void FrameStore::add(std::string message, double wall_s) {
  const std::lock_guard lock(mutex_);
  bytes_ += message.size();
  frames_.push_back({std::make_shared<const std::string>(std::move(message)), wall_s});
  while (frames_.size() > 1 && (bytes_ > kMaxBytes || wall_s - frames_.front().wall_s > kKept_s)) {
    bytes_ -= frames_.front().message->size();
    frames_.pop_front();
    ++first_;
  }
}

Message FrameStore::get(std::optional<std::uint64_t> number) const {
  const std::lock_guard lock(mutex_);
  if (frames_.empty()) return nullptr;
  if (!number) return frames_.back().message;
  if (*number < first_ || *number - first_ >= frames_.size()) return nullptr;
  return frames_[*number - first_].message;
}

std::uint64_t FrameStore::first() const {
  const std::lock_guard lock(mutex_);
  return first_;
}

std::uint64_t FrameStore::last() const {
  const std::lock_guard lock(mutex_);
  return first_ + frames_.size() - 1;
}

}  // namespace stillgrid::scene_viewer
