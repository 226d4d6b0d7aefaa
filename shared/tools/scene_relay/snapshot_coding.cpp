#include "shared/tools/scene_relay/snapshot_coding.hpp"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "shared/tools/scene_relay/sequence.hpp"
#include "shared/tools/scene_relay/told_scene.hpp"

namespace stillgrid::scene_relay {
namespace {

/// Lists those of `now` whose bits are others than in `before`, and copies them; false, and lists
/// none, where most are, so that telling all is shorter.
template <class Element>
bool differing(const std::vector<Element>& before, const std::vector<Element>& now,
               std::vector<std::uint32_t>& numbers, std::vector<Element>& values) {
  numbers.clear();
  values.clear();
  const std::size_t worthwhile = now.size() * sizeof(Element) / (sizeof(Element) + 4);
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (std::memcmp(&before[i], &now[i], sizeof(Element)) == 0) continue;
    if (numbers.size() + 1 >= worthwhile) {
      numbers.clear();
      return false;
    }
    numbers.push_back(static_cast<std::uint32_t>(i));
    values.push_back(now[i]);
  }
  return true;
}

/// An array as a message tells it, into `values`, which hold the keyframe's or nothing.
template <class Element>
bool apply(std::span<const std::uint32_t> numbers, std::span<const Element> told, std::size_t count,
           std::vector<Element>& values) {
  if (numbers.empty() && told.size() == count) {
    values.assign(told.begin(), told.end());
    return true;
  }
  if (values.size() != count || told.size() != numbers.size()) return false;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] >= count || (i > 0 && numbers[i] <= numbers[i - 1])) return false;
    values[numbers[i]] = told[i];
  }
  return true;
}

/// What a snapshot and its message call alike.
template <class From, class To>
void copy_head(const From& from, To& to) {
  to.snapshot_id = from.snapshot_id;
  to.state_time_ns = from.state_time_ns;
  to.publish_time_ns = from.publish_time_ns;
  to.tool_time_ns = from.tool_time_ns;
  to.step_ns = from.step_ns;
  to.contacts = from.contacts;
  to.tool_work_J = from.tool_work_J;
  to.state_tick = from.state_tick;
  to.state_hash = from.state_hash;
}

[[noreturn]] void refuse() {
  throw MessageError("a snapshot is refused: its counts, or which spheres it tells of");
}

template <class Sequence>
std::size_t bytes_of(const Sequence& sequence) {
  return std::size_t{sequence._length} * sizeof(*sequence._buffer);
}

template <class Element, class Sequence>
void assign(std::vector<Element>& values, const Sequence& sequence) {
  const auto told = elements(sequence);
  values.assign(told.begin(), told.end());
}

}  // namespace

std::size_t message_bytes(const SnapshotMessage& message) noexcept {
  return 128 + bytes_of(message.moved) + bytes_of(message.motions) + bytes_of(message.relabelled) +
         bytes_of(message.labels) + bytes_of(message.fields) + bytes_of(message.state);
}

void SnapshotEncoder::tell_whole() {
  moved_.clear();
  relabelled_.clear();
  point_to(message_.moved, moved_);
  point_to(message_.relabelled, relabelled_);
  point_to(message_.motions, snapshot_.motions);
  point_to(message_.labels, snapshot_.labels);
  message_.against_id = 0;
}

void SnapshotEncoder::tell_against(const ToldSnapshot& keyframe) {
  message_.against_id = keyframe.snapshot_id;
  if (differing(keyframe.motions, snapshot_.motions, moved_, motions_))
    point_to(message_.motions, motions_);
  if (differing(keyframe.labels, snapshot_.labels, relabelled_, labels_))
    point_to(message_.labels, labels_);
  point_to(message_.moved, moved_);
  point_to(message_.relabelled, relabelled_);
}

/// Who publishes often would else never hear of a keyframe before the next one.
bool SnapshotEncoder::is_awaited() const noexcept {
  return sent_ && (number_ < sent_number_ + kPatience ||
                   snapshot_.publish_time_ns - sent_->publish_time_ns < kPatience_ns);
}

const SnapshotMessage& SnapshotEncoder::encode(ToldSnapshot snapshot, std::uint64_t scene_epoch) {
  if (scene_epoch != scene_epoch_) {
    held_.reset();
    sent_.reset();
  }
  scene_epoch_ = scene_epoch;
  snapshot_ = std::move(snapshot);
  message_ = {};
  message_.relay_id = relay_id_;
  message_.number = ++number_;
  message_.scene_epoch = scene_epoch;
  copy_head(snapshot_, message_);
  message_.sphere_count = static_cast<std::uint32_t>(snapshot_.motions.size());
  point_to(message_.fields, snapshot_.fields);
  tell_spheres();
  point_to(message_.state, snapshot_.state);
  deltas_ += message_.against_id != 0 ? 1 : 0;
  return message_;
}

/// The state does not count here: it is told whole with a delta too.
void SnapshotEncoder::tell_spheres() {
  tell_whole();
  const std::size_t whole_bytes = message_bytes(message_);
  if (!has_deltas_ || whole_bytes < kDeltaFrom_bytes) return;
  bool is_stale = !held_ || held_->motions.size() != snapshot_.motions.size();
  if (!is_stale) {
    tell_against(*held_);
    is_stale = 2 * message_bytes(message_) > whole_bytes && number_ >= held_number_ + kFreshFor;
  }
  if (!is_stale || is_awaited()) return;
  tell_whole();
  message_.is_keyframe = true;
  sent_ = snapshot_;
  sent_->state.clear();
  sent_number_ = number_;
  ++keyframes_;
}

void SnapshotEncoder::acknowledge(std::uint64_t scene_epoch, std::uint64_t keyframe_id) {
  if (scene_epoch != scene_epoch_) return;
  if (sent_ && sent_->snapshot_id == keyframe_id) {
    held_ = std::exchange(sent_, std::nullopt);
    held_number_ = sent_number_;
  } else if (keyframe_id == 0 && held_) {
    held_.reset();  // the other side began anew
  }
}

Decoded SnapshotDecoder::decode(const SnapshotMessage& message, const SnapshotLimits& limits,
                                ToldSnapshot& snapshot) {
  if (message.sphere_count > limits.moving_capacity ||
      (message.is_keyframe && message.against_id != 0))
    refuse();
  snapshot.motions.clear();
  snapshot.labels.clear();
  if (message.against_id != 0) {
    const auto keyframe = std::find_if(
        keyframes_.begin(), keyframes_.end(),
        [&](const ToldSnapshot& kept) { return kept.snapshot_id == message.against_id; });
    if (keyframe == keyframes_.end()) return Decoded::kWithoutKeyframe;
    keyframes_.erase(keyframes_.begin(), keyframe);
    snapshot.motions = keyframes_.front().motions;
    snapshot.labels = keyframes_.front().labels;
  }
  if (!apply(elements(message.moved), elements(message.motions), message.sphere_count,
             snapshot.motions) ||
      !apply(elements(message.relabelled), elements(message.labels), message.sphere_count,
             snapshot.labels))
    refuse();
  copy_head(message, snapshot);
  assign(snapshot.fields, message.fields);
  assign(snapshot.state, message.state);
  check(snapshot, limits);
  if (message.is_keyframe && message.snapshot_id > keyframe_id()) keep(snapshot);
  return Decoded::kSnapshot;
}

void SnapshotDecoder::keep(const ToldSnapshot& snapshot) {
  keyframes_.push_back(snapshot);
  keyframes_.back().state.clear();
  // The sender tells deltas to the first until it hears of another.
  if (keyframes_.size() > kKept) keyframes_.erase(keyframes_.begin() + 1);
}

}  // namespace stillgrid::scene_relay
