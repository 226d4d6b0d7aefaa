#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "shared/tools/scene_relay/told_snapshot.hpp"

namespace stillgrid::scene_relay {

/// How a generated scene goes on from snapshot to snapshot.
enum class Going {
  kAtRest,
  kSomeMove,  // one in twenty
  kAllMove,
  kComeAndGo,  // spheres are taken away and added at the end
  kRelabelled  // some are of another radius, material or body
};
inline constexpr Going kGoings[] = {Going::kAtRest, Going::kSomeMove, Going::kAllMove,
                                    Going::kComeAndGo, Going::kRelabelled};

/// Snapshots that a seed decides, of up to so many spheres, with numbers that are sound.
class GeneratedSnapshots {
 public:
  static constexpr std::uint32_t kStateCapacity = 300;  // bytes

  GeneratedSnapshots(std::uint32_t seed, Going going, std::uint32_t spheres,
                     std::uint64_t period_ns = 33'333'333);

  /// The next one; its id is one more than the last's.
  const ToldSnapshot& next();
  /// The scene is begun anew, its ids from 1.
  void begin_anew();

  [[nodiscard]] SnapshotLimits limits() const noexcept {
    return {.moving_capacity = capacity_,
            .material_count = 2,
            .moving_fields = 2,
            .state_capacity = kStateCapacity};
  }

 private:
  float number(float least, float most) {
    return std::uniform_real_distribution<float>(least, most)(random_);
  }
  bool is_one_of(double share) { return std::bernoulli_distribution(share)(random_); }
  Motion motion();
  Label label();
  FieldMotion field();
  void go_on();

  std::mt19937 random_;
  Going going_;
  std::uint32_t capacity_;
  std::uint64_t period_ns_;
  ToldSnapshot snapshot_;
};

/// Whether two tell the same, bit for bit.
[[nodiscard]] bool are_same(const ToldSnapshot& a, const ToldSnapshot& b);

/// A message that lives by itself, as one that is on its way.
class KeptMessage {
 public:
  explicit KeptMessage(const SnapshotMessage& message);
  KeptMessage(const KeptMessage& other) : KeptMessage(other.message_) {}
  KeptMessage& operator=(const KeptMessage&) = delete;

  [[nodiscard]] const SnapshotMessage& message() const noexcept { return message_; }
  [[nodiscard]] SnapshotMessage& message() noexcept { return message_; }

 private:
  SnapshotMessage message_;
  std::vector<std::uint32_t> moved_, relabelled_;
  std::vector<Motion> motions_;
  std::vector<Label> labels_;
  std::vector<FieldMotion> fields_;
  std::vector<std::uint8_t> state_;
};

}  // namespace stillgrid::scene_relay
