#include "haptic_server/rendering/velocity_estimator.hpp"

#include <cmath>
#include <utility>

namespace stillgrid {

Eigen::Vector3d VelocityEstimator::update(std::uint64_t time_ns,
                                          const Eigen::Vector3d& position_m) noexcept {
  constexpr double kTimeConstant_s = 0.005;
  if (has_sample_ && time_ns <= time_ns_) return velocity_m_s_;
  const double step_s = static_cast<double>(time_ns - std::exchange(time_ns_, time_ns)) * 1e-9;
  const Eigen::Vector3d moved_m = position_m - position_m_;
  position_m_ = position_m;
  if (!std::exchange(has_sample_, true)) return velocity_m_s_;
  const double pull = 1.0 - std::exp(-step_s / kTimeConstant_s);
  velocity_m_s_ += pull * (moved_m / step_s - velocity_m_s_);
  return velocity_m_s_;
}

}  // namespace stillgrid
