#pragma once

#include <Eigen/Core>

namespace stillgrid::dynamics {

/// A force, N, and its moment about a point, N m. Frame of the world. Of a rigid body the point is
/// its centre of mass, and of a tool its origin.
struct Wrench {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero(), torque_N_m = Eigen::Vector3d::Zero();
};

}  // namespace stillgrid::dynamics
