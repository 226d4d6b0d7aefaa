#pragma once

#include <Eigen/Core>

namespace stillgrid::bodies {

enum class Motion { kFree, kStatic, kPrescribed };

/// Motion known in advance: either steady, or a sine along one direction that starts at rest
/// position.
struct PrescribedMotion {
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  // steady motion
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();    // of the sine, unit
  double amplitude_m = 0.0;
  double frequency_hz = 0.0;
};

}  // namespace stillgrid::bodies
