#include "shared/rendering/velocity_estimator.hpp"

#include <cmath>
#include <utility>

namespace stillgrid::rendering {
namespace {

constexpr double kTimeConstant_s = 0.005;

/// Share of the way to a new rate that the low-pass goes in a step.
double pull(double step_s) {
  return 1.0 - std::exp(-step_s / kTimeConstant_s);
}

}  // namespace

Eigen::Vector3d rotation_rad(const Eigen::Quaterniond& turn) noexcept {
  const double sine = turn.vec().norm();
  if (sine == 0.0) return Eigen::Vector3d::Zero();
  const double half_angle_rad = std::atan2(sine, std::abs(turn.w()));
  return std::copysign(2.0 * half_angle_rad / sine, turn.w()) * turn.vec();
}

Eigen::Vector3d VelocityEstimator::update(std::uint64_t time_ns,
                                          const Eigen::Vector3d& position_m) noexcept {
  if (has_sample_ && time_ns <= time_ns_) return velocity_m_s_;
  const double step_s = static_cast<double>(time_ns - std::exchange(time_ns_, time_ns)) * 1e-9;
  const Eigen::Vector3d moved_m = position_m - position_m_;
  position_m_ = position_m;
  if (!std::exchange(has_sample_, true)) return velocity_m_s_;
  velocity_m_s_ += pull(step_s) * (moved_m / step_s - velocity_m_s_);
  return velocity_m_s_;
}

Eigen::Vector3d AngularVelocityEstimator::update(std::uint64_t time_ns,
                                                 const Eigen::Quaterniond& orientation) noexcept {
  if (has_sample_ && time_ns <= time_ns_) return velocity_rad_s_;
  const double step_s = static_cast<double>(time_ns - std::exchange(time_ns_, time_ns)) * 1e-9;
  const Eigen::Quaterniond turn = orientation * orientation_.conjugate();
  orientation_ = orientation;
  if (!std::exchange(has_sample_, true)) return velocity_rad_s_;
  velocity_rad_s_ += pull(step_s) * (rotation_rad(turn) / step_s - velocity_rad_s_);
  return velocity_rad_s_;
}

}  // namespace stillgrid::rendering
