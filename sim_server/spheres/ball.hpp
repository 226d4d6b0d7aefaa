#pragma once

#include <Eigen/Core>

namespace stillgrid::spheres {

/// A sphere of a decomposition, in the body's own frame.
struct Ball {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
};

}  // namespace stillgrid::spheres
