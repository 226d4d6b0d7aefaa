#pragma once

#include "tests/laboratory/rivals/local_model.hpp"

namespace stillgrid::laboratory {

/// The slow process's force and torque with their derivatives by the tool's place and velocity:
/// W0 + J (x - x0) + D (v - v0), both with rotation [Picinbono 2000; Cavusoglu 2000; the spring and
/// damper Jacobians of OpenSurgSim].
class ForceJacobian final : public LocalModel {
 public:
  void update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool& present,
              bool is_first) noexcept override;
  [[nodiscard]] rendering::ToolForce force(const LocalScene& scene,
                                           const PlacedTool& tool) noexcept override;

 private:
  using Twist = Eigen::Matrix<double, 6, 1>;  // along x, y, z, then about them; a wrench likewise

  rendering::ToolPose pose_;
  rendering::ToolForce at_sample_;
  Twist wrench_ = Twist::Zero();
  Eigen::Matrix<double, 6, 6> by_place_ = Eigen::Matrix<double, 6, 6>::Zero(),
                              by_velocity_ = by_place_;
};

}  // namespace stillgrid::laboratory
