#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "proto/scene_segment.hpp"
#include "proto/stillgrid.h"

namespace stillgrid::library {

using Twist = Eigen::Matrix<double, 6, 1>;

/// How a body gives way, as modes of one step: motions B of its centre, of unit energy, so that a
/// wrench moves the body by B B^T of it over the step. B B^T is the square of the step's length
/// times the inverse inertia (docs/library.md).
class BodyModes {
 public:
  BodyModes() = default;

  /// False where the inverse inertia is not symmetric, or has an eigenvalue below 0.
  /// Pre: numbers.
  [[nodiscard]] bool take(const stillgrid_response& response) noexcept;
  /// Sets the step that modes are for.
  void set_step(double step_s) noexcept { step_s_ = step_s; }

  [[nodiscard]] std::uint32_t body() const noexcept { return body_; }
  [[nodiscard]] int count() const noexcept { return count_; }
  [[nodiscard]] const Eigen::Vector3d& centre_m() const noexcept { return centre_m_; }
  /// Of the centre, and about it; m/sqrt(J), rad/sqrt(J).
  [[nodiscard]] Twist motion(int mode) const noexcept { return step_s_ * motions_.col(mode); }
  /// Of a point of the body; sqrt(m/N).
  [[nodiscard]] Eigen::Vector3d motion_at(int mode, const Eigen::Vector3d& point_m) const noexcept {
    const Twist motion = this->motion(mode);
    return motion.head<3>() + motion.tail<3>().cross(point_m - centre_m_);
  }
  /// Of the pushes of this body, at its centre and about it.
  [[nodiscard]] Twist wrench_of(std::span<const stillgrid_push> pushes) const noexcept;

 private:
  std::uint32_t body_ = 0;
  int count_ = 0;
  double step_s_ = 0.0;
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 6, 6> motions_ = Eigen::Matrix<double, 6, 6>::Zero();  // of a step of 1 s
};

}  // namespace stillgrid::library
