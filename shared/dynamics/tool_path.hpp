#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace stillgrid::dynamics {

/// Pose and velocity of a tool, in the frame of the world.
struct ToolPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};
/// A tool in the tick of this number.
struct PathPose : ToolPose {
  std::uint64_t number = 0;
};

/// The last samples of a tool's path, and the poses between them. A pose depends on its own sample
/// alone, or on its two neighbours. Two processes that hold these get the same pose to the bit.
///
/// Thread: one. Realtime: yes, but for the constructor, which allocates.
class TickPath {
 public:
  static constexpr std::size_t kLength = 4096;       // samples
  static constexpr std::uint64_t kLongestGap = 100;  // ticks from one sample to the next

  TickPath() : samples_(kLength) {}
  /// Forgets all samples. Realtime: yes.
  void clear() noexcept { count_ = 0; }

  /// Adds a sample and normalises its orientation. Drops the oldest sample if there are kLength.
  /// Ignores a sample whose number is not above the newest one's. Pre: its numbers are finite, its
  /// orientation is nearly a unit quaternion.
  void add(PathPose sample) noexcept;

  /// Returns the numbers of the newest and of the oldest sample, once there is one.
  [[nodiscard]] std::optional<std::uint64_t> newest() const noexcept;
  [[nodiscard]] std::optional<std::uint64_t> oldest() const noexcept;

  /// Returns the pose in tick n, from the oldest sample to the newest. If sample n is missing the
  /// tool goes evenly from its neighbour before to its neighbour after: on a line and about a fixed
  /// axis. Its velocity changes evenly too. If the neighbours are more than kLongestGap ticks apart
  /// the tool was away: there is no pose between them.
  [[nodiscard]] std::optional<PathPose> pose_at(std::uint64_t n) const noexcept;

 private:
  [[nodiscard]] const PathPose& sample(std::uint64_t index) const noexcept {
    return samples_[index % kLength];
  }
  [[nodiscard]] std::uint64_t first() const noexcept {
    return count_ - std::min<std::uint64_t>(count_, kLength);
  }

  std::vector<PathPose> samples_;
  std::uint64_t count_ = 0;  // samples added; sample k has index k modulo kLength
};

/// Returns the pose in tick n as TickPath::pose_at(). The tool goes on evenly for led_on_ticks
/// beyond the newest sample, then it is away. Realtime: yes.
[[nodiscard]] std::optional<ToolPose> led_on_pose(const TickPath& path, std::uint64_t n,
                                                  std::uint64_t led_on_ticks) noexcept;

/// Adds to `path` the newer samples of a path in shared memory, of its last kLength ticks. Samples
/// that were overwritten meanwhile are missing. View: a type with newest() and sample() as
/// publication::PathView has them. Realtime: as the view.
template <class View>
void follow(const View& view, TickPath& path) {
  const std::optional<std::uint64_t> newest = view.newest(), known = path.newest();
  if (!newest || (known && *known >= *newest)) return;
  const std::uint64_t kept = *newest - std::min<std::uint64_t>(*newest, TickPath::kLength - 1);
  for (std::uint64_t n = known ? std::max(*known + 1, kept) : kept; n <= *newest; ++n)
    if (const auto sample = view.sample(n))
      path.add({{Eigen::Vector3d(sample->position_m.data()),
                 Eigen::Quaterniond(sample->orientation_xyzw.data()),
                 Eigen::Vector3d(sample->velocity_m_s.data())},
                n});
}

}  // namespace stillgrid::dynamics
