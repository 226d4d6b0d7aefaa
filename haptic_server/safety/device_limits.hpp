#pragma once

#include <optional>

#include "haptic_server/safety/safety_chain.hpp"
#include "proto/device_plugin.h"

namespace stillgrid::safety {

/// What a user asks of the chain; nothing: what the device declares.
struct SafetyOptions {
  std::optional<double> max_force_N = {};  // the device's own is the upper bound
  std::optional<double> max_slew_N_per_ms = {};
  std::optional<double> max_stiffness_N_per_m = {};
  std::optional<double> max_speed_m_s = {};
  std::optional<double> passivity_mass_kg = {};  // of the control of energy, if there is to be one
  double gripper_stiffness_N_per_m = 0.0;        // of the spring that opens a device's gripper
};

/// The limits that a device is held to: as declared, and as asked for where that is stricter or the
/// user knows better. A device that declares no force is held to 40 N; one that declares no
/// stiffness, speed, workspace or continuous force is not held to any; a motor's time constant that
/// is not declared is taken for 10 s, a torque that is not for that of the force's limit at 0.1 m.
/// By default the force grows by a tenth of its limit in a millisecond.
[[nodiscard]] SafetyLimits safety_limits(const SafetyOptions& options,
                                         const stillgrid_device_descriptor& device);

}  // namespace stillgrid::safety
