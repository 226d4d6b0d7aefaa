#pragma once

#include <Eigen/Core>

namespace stillgrid::bodies {

enum class Motion { kFree, kStatic, kPrescribed };

/// Motion known in advance, along one direction: either steady, or a sine that starts at
/// rest position.
struct PrescribedMotion {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit
  double velocity_m_s = 0.0;                             // steady motion
  double amplitude_m = 0.0;                              // sine
  double frequency_hz = 0.0;
};

}  // namespace stillgrid::bodies
