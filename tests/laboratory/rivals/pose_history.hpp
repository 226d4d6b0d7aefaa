#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "shared/rendering/tool_force.hpp"

namespace stillgrid::laboratory {

/// The tool's poses of the last ticks, as far back as the oldest sample a snapshot may contain.
class PoseHistory {
 public:
  static constexpr std::size_t kCapacity = 512;

  /// Realtime: yes.
  void push(std::uint64_t time_ns, const rendering::ToolPose& pose) noexcept {
    const std::size_t slot = pushed_++ % kCapacity;
    times_ns_[slot] = time_ns;
    poses_[slot] = pose;
  }

  /// The pose pushed last at time_ns or before it; the oldest kept if all are later.
  /// Realtime: bounded by the capacity. Pre: one was pushed.
  [[nodiscard]] const rendering::ToolPose& at(std::uint64_t time_ns) const noexcept {
    std::size_t i = pushed_ - 1;
    const std::size_t oldest = pushed_ > kCapacity ? pushed_ - kCapacity : 0;
    while (i > oldest && times_ns_[i % kCapacity] > time_ns) --i;
    return poses_[i % kCapacity];
  }

 private:
  std::size_t pushed_ = 0;
  std::array<std::uint64_t, kCapacity> times_ns_{};
  std::array<rendering::ToolPose, kCapacity> poses_;
};

}  // namespace stillgrid::laboratory
