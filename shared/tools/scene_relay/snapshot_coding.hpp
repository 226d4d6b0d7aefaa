#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "shared/tools/scene_relay/told_snapshot.hpp"

namespace stillgrid::scene_relay {

/// What a message takes, about; bytes.
[[nodiscard]] std::size_t message_bytes(const SnapshotMessage& message) noexcept;

/// Snapshots as messages: whole, or where that is more than kDeltaFrom_bytes as a delta against a
/// keyframe that the other side has said it holds, so that no loss can make a wrong one. A sphere
/// is told again if a bit of its motion, or of its label, is another than in the keyframe. Each
/// message has the whole state.
///
/// Thread: one.
class SnapshotEncoder {
 public:
  /// Below it, two packets, a delta spares nothing that could be lost.
  static constexpr std::size_t kDeltaFrom_bytes = 2688;
  /// A keyframe is sent anew when it was not acknowledged after so many snapshots and so long, the
  /// longest way there and back, and when deltas to it have grown to half of the whole, but not
  /// before kFreshFor snapshots.
  static constexpr std::uint64_t kPatience = 16, kPatience_ns = 600'000'000, kFreshFor = 32;

  explicit SnapshotEncoder(std::uint64_t relay_id, bool has_deltas = true)
      : relay_id_(relay_id), has_deltas_(has_deltas) {}

  /// The message, good until the next call.
  [[nodiscard]] const SnapshotMessage& encode(ToldSnapshot snapshot, std::uint64_t scene_epoch);

  /// The other side holds that keyframe of that scene; 0: none.
  void acknowledge(std::uint64_t scene_epoch, std::uint64_t keyframe_id);

  [[nodiscard]] std::uint64_t keyframes() const noexcept { return keyframes_; }
  [[nodiscard]] std::uint64_t deltas() const noexcept { return deltas_; }

 private:
  [[nodiscard]] bool is_awaited() const noexcept;
  void tell_against(const ToldSnapshot& keyframe);
  void tell_spheres();
  void tell_whole();

  std::uint64_t relay_id_;
  bool has_deltas_;
  std::uint64_t number_ = 0, scene_epoch_ = 0;
  ToldSnapshot snapshot_;                          // that the message tells of
  std::vector<std::uint32_t> moved_, relabelled_;  // in a delta
  std::vector<Motion> motions_;
  std::vector<Label> labels_;
  SnapshotMessage message_{};
  std::optional<ToldSnapshot> held_, sent_;  // keyframes: acknowledged, not yet
  std::uint64_t held_number_ = 0, sent_number_ = 0;
  std::uint64_t keyframes_ = 0, deltas_ = 0;
};

/// What became of a message.
enum class Decoded {
  kSnapshot,
  kWithoutKeyframe,  // a delta to one that is not here: it was lost
};

/// The other end. Keeps the last keyframes of a scene. Thread: one.
class SnapshotDecoder {
 public:
  /// Fills `snapshot`, whose counts, indices and numbers are sound, as those of any that is kept.
  /// Throws MessageError where they are not: `snapshot` holds anything then. Pre: the message is of
  /// the scene that was begun, and the limits are its.
  [[nodiscard]] Decoded decode(const SnapshotMessage& message, const SnapshotLimits& limits,
                               ToldSnapshot& snapshot);

  /// Another scene: keyframes of the one before tell nothing of it.
  void begin() { keyframes_.clear(); }

  /// That the sender may tell deltas to; 0: none.
  [[nodiscard]] std::uint64_t keyframe_id() const noexcept {
    return keyframes_.empty() ? 0 : keyframes_.back().snapshot_id;
  }

 private:
  void keep(const ToldSnapshot& snapshot);

  static constexpr std::size_t kKept = 3;
  std::deque<ToldSnapshot> keyframes_;  // ascending, from the one that deltas are told to
};

}  // namespace stillgrid::scene_relay
