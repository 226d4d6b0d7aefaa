#include "shared/dynamics/tool_path.hpp"

#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {

void TickPath::add(PathPose added) noexcept {
  if (count_ > 0 && added.number <= sample(count_ - 1).number) return;
  added.orientation.normalize();
  samples_[count_++ % kLength] = added;
}

std::optional<std::uint64_t> TickPath::newest() const noexcept {
  if (count_ == 0) return std::nullopt;
  return sample(count_ - 1).number;
}

std::optional<std::uint64_t> TickPath::oldest() const noexcept {
  if (count_ == 0) return std::nullopt;
  return sample(first()).number;
}

std::optional<PathPose> TickPath::pose_at(std::uint64_t n) const noexcept {
  if (count_ == 0 || n < sample(first()).number || n > sample(count_ - 1).number)
    return std::nullopt;
  std::uint64_t low = first(), high = count_ - 1;  // the sample of n or after it is in [low, high]
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    if (sample(middle).number < n)
      low = middle + 1;
    else
      high = middle;
  }
  const PathPose& after = sample(low);
  if (after.number == n) return after;
  const PathPose& before = sample(low - 1);
  const std::uint64_t gap = after.number - before.number;
  if (gap > kLongestGap) return std::nullopt;
  const double share = static_cast<double>(n - before.number) / static_cast<double>(gap);
  const Eigen::Vector3d turn_rad =
      rotation_vector(after.orientation * before.orientation.conjugate());
  return PathPose{{before.position_m + share * (after.position_m - before.position_m),
                   (rotation_by(share * turn_rad) * before.orientation).normalized(),
                   before.velocity_m_s + share * (after.velocity_m_s - before.velocity_m_s)},
                  n};
}

std::optional<ToolPose> led_on_pose(const TickPath& path, std::uint64_t n,
                                    std::uint64_t led_on_ticks) noexcept {
  const std::uint64_t led_on = n - std::min(n, path.newest().value_or(n));
  if (led_on > led_on_ticks) return std::nullopt;
  std::optional<ToolPose> pose = path.pose_at(n - led_on);
  if (pose && led_on > 0)
    pose->position_m += static_cast<double>(led_on) * kTick_s * pose->velocity_m_s;
  return pose;
}

}  // namespace stillgrid::dynamics
