#pragma once

#include <Eigen/Core>

namespace stillgrid::dynamics {

/// A force, N, and its moment about a point, N m. Frame of the world. The point is the
/// centre of mass of a rigid body, or the origin of a tool.
struct Wrench {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero(), torque_N_m = Eigen::Vector3d::Zero();
};

}  // namespace stillgrid::dynamics
