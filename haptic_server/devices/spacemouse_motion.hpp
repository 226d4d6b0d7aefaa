#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace stillgrid::devices {

/// What a SpaceMouse's cap shows: x, y, z, rx, ry, rz in the daemon's counts.
using CapCounts = std::array<int, 6>;

/// How the cap's deflection moves the tool.
struct SpacemouseSettings {
  double speed_m_s = 0.1;       // at full deflection, >= 0
  double rotation_rad_s = 1.0;  // likewise
  double dead_zone = 0.05;      // share of full deflection that does nothing, in [0, 1)
  double full_scale = 350.0;    // counts of full deflection, > 0
  double range_m = 0.1;         // |x|, |y| and |z| stay within it, > 0
  Eigen::Vector3d start_m = Eigen::Vector3d(0.0, 0.0, 0.03);
};

/// Where the tool is that the cap steers, device frame: x to the right, y away from the user, z up.
struct SteeredPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  // device from tool
};

/// Steers the tool for duration_s by a cap held like this: the deflection is a velocity.
///
/// The daemon's x points to the right, y up and z away from the user; rx, ry and rz are
/// right-handed turns about these directions [libspnav, spnav_posrot_moveobj()]. The dead zone
/// is of the norm, and what is beyond it begins at zero speed. Beyond full deflection it gets no
/// faster.
/// Realtime: never allocates, locks or throws.
/// Pre: the bounds of SpacemouseSettings; duration_s >= 0.
void steer(SteeredPose& pose, const CapCounts& counts, const SpacemouseSettings& settings,
           double duration_s) noexcept;

}  // namespace stillgrid::devices
