#pragma once

#include <Eigen/Core>
#include <vector>

namespace stillgrid::fields {

/// How stiff a body's contact is at a place on or near its surface.
struct StiffnessPlace {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double stiffness_N_per_m = 0.0;
};

/// What a measurement says of a body's surface beyond its mesh, in the mesh's frame.
struct MeasuredSurface {
  double offset_m = 0.0;                    // by which the surface lies outside of the mesh
  std::vector<StiffnessPlace> places = {};  // none: even
  double own_N_per_m = 1.0;                 // the body's stiffness, where no place is near
};

}  // namespace stillgrid::fields
