#include "shared/dynamics/prescribed_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stillgrid::dynamics {
namespace {

struct Displacement {
  Eigen::Vector3d displacement_m = Eigen::Vector3d::Zero(), velocity_m_s = Eigen::Vector3d::Zero();
};

Keyframe keyframe(const PrescribedMotion::Keyframes& keyframes, std::size_t k) {
  return k == 0 ? Keyframe{} : keyframes[k - 1];  // the start
}

/// Mean velocity from a keyframe to the next.
Eigen::Vector3d mean_m_s(const PrescribedMotion::Keyframes& keyframes, std::size_t k) {
  const Keyframe from = keyframe(keyframes, k), to = keyframe(keyframes, k + 1);
  return (to.displacement_m - from.displacement_m) / (to.time_s - from.time_s);
}

/// Velocity at a keyframe: the weighted harmonic mean of the velocities before and after it, zero
/// in an axis in which they differ in sign.
Eigen::Vector3d velocity_m_s(const PrescribedMotion::Keyframes& keyframes, std::size_t k) {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  if (k == 0 || k == keyframes.size()) return velocity;
  const Eigen::Vector3d before = mean_m_s(keyframes, k - 1), after = mean_m_s(keyframes, k);
  const double now_s = keyframe(keyframes, k).time_s,
               before_s = now_s - keyframe(keyframes, k - 1).time_s,
               after_s = keyframe(keyframes, k + 1).time_s - now_s;
  for (Eigen::Index i = 0; i < 3; ++i)
    if (before[i] * after[i] > 0.0)
      velocity[i] =
          3.0 * (before_s + after_s) /
          ((2.0 * after_s + before_s) / before[i] + (after_s + 2.0 * before_s) / after[i]);
  return velocity;
}

Displacement displacement(const PrescribedMotion::Keyframes& keyframes, double time_s) {
  if (keyframes.empty() || time_s <= 0.0) return {};
  const auto next = std::ranges::upper_bound(keyframes, time_s, {}, &Keyframe::time_s);
  if (next == keyframes.end()) return {keyframes.back().displacement_m};
  const auto k = static_cast<std::size_t>(next - keyframes.begin());
  const Keyframe from = keyframe(keyframes, k);
  const double duration_s = next->time_s - from.time_s, u = (time_s - from.time_s) / duration_s;
  const Eigen::Vector3d way_m = next->displacement_m - from.displacement_m,
                        begin_m = duration_s * velocity_m_s(keyframes, k),
                        end_m = duration_s * velocity_m_s(keyframes, k + 1);
  const Eigen::Vector3d square = 3.0 * way_m - 2.0 * begin_m - end_m,
                        cube = begin_m + end_m - 2.0 * way_m;
  return {from.displacement_m + u * (begin_m + u * (square + u * cube)),
          (begin_m + u * (2.0 * square + 3.0 * u * cube)) / duration_s};
}

}  // namespace

Eigen::Vector3d PrescribedMotion::position_m(double time_s) const {
  const double rate_rad_s = 2.0 * std::numbers::pi * frequency_hz;
  const double offset_m = amplitude_m * std::sin(rate_rad_s * time_s);
  const Eigen::Vector3d position_m = start_m + time_s * velocity_m_s + offset_m * direction;
  return keyframes ? Eigen::Vector3d(position_m + displacement(*keyframes, time_s).displacement_m)
                   : position_m;
}

Eigen::Vector3d PrescribedMotion::velocity_at_m_s(double time_s) const {
  const double rate_rad_s = 2.0 * std::numbers::pi * frequency_hz;
  const double speed_m_s = amplitude_m * rate_rad_s * std::cos(rate_rad_s * time_s);
  const Eigen::Vector3d at_m_s = velocity_m_s + speed_m_s * direction;
  return keyframes ? Eigen::Vector3d(at_m_s + displacement(*keyframes, time_s).velocity_m_s)
                   : at_m_s;
}

double PrescribedMotion::highest_speed_m_s() const {
  double of_keyframes_m_s = 0.0;
  for (std::size_t k = 0; keyframes && k < keyframes->size(); ++k) {
    const double end_s = (*keyframes)[k].time_s,
                 middle_s = 0.5 * (keyframe(*keyframes, k).time_s + end_s);
    for (const double time_s : {middle_s, end_s})
      of_keyframes_m_s =
          std::max(of_keyframes_m_s, displacement(*keyframes, time_s).velocity_m_s.norm());
  }
  return velocity_m_s.norm() + 2.0 * std::numbers::pi * frequency_hz * amplitude_m +
         of_keyframes_m_s;
}

}  // namespace stillgrid::dynamics
