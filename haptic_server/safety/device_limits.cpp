#include "haptic_server/safety/device_limits.hpp"

#include <algorithm>

namespace stillgrid::safety {
namespace {

constexpr double kUndeclaredForce_N = 40.0;
constexpr double kUndeclaredTimeConstant_s = 10.0;
constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr double kDefaultSlew_per_ms = 0.1;  // of the force's limit

double declared_or(double declared, double otherwise) {
  return declared > 0.0 ? declared : otherwise;
}

}  // namespace

SafetyLimits safety_limits(const SafetyOptions& options,
                           const stillgrid_device_descriptor& device) {
  const double device_N = declared_or(device.max_force_N, kUndeclaredForce_N);
  SafetyLimits limits;
  limits.max_force_N = std::min(options.max_force_N.value_or(device_N), device_N);
  // A user who asks for less force gets less torque, too.
  if (device.max_torque_N_m > 0.0) limits.lever_m = device.max_torque_N_m / device_N;
  limits.max_slew_N_per_ms =
      options.max_slew_N_per_ms.value_or(kDefaultSlew_per_ms * limits.max_force_N);
  limits.stiffness_N_per_m =
      options.max_stiffness_N_per_m.value_or(declared_or(device.nominal_stiffness_N_per_m, kNone));
  limits.continuous_force_N = declared_or(device.continuous_force_N, kNone);
  limits.continuous_torque_N_m = declared_or(device.continuous_torque_N_m, kNone);
  limits.motor_time_constant_s =
      declared_or(device.motor_time_constant_s, kUndeclaredTimeConstant_s);
  limits.max_speed_m_s = options.max_speed_m_s.value_or(declared_or(device.max_speed_m_s, kNone));
  limits.workspace = {Eigen::Vector3d(device.workspace_min_m),
                      Eigen::Vector3d(device.workspace_max_m)};
  limits.passivity_mass_kg = options.passivity_mass_kg;
  limits.gripper = {options.gripper_stiffness_N_per_m, device.gripper_open_m,
                    device.max_gripper_force_N};
  return limits;
}

}  // namespace stillgrid::safety
