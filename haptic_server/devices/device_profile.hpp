#pragma once

#include <array>
#include <span>
#include <string_view>

#include "proto/device_plugin.h"

namespace stillgrid::devices {

/// What was published about a device; zero where no source was found. docs/devices.md has sources.
struct DeviceProfile {
  const char* words;  // all of them, in small letters, in the name that the vendor's library tells
  double max_force_N;
  double continuous_force_N;
  double nominal_stiffness_N_per_m;
  std::array<double, 3> workspace_m;  // extent along the axes, about the origin
  double max_torque_N_m;
  double max_gripper_force_N;
};

/// The profiles of Force Dimension's devices, and of those that 3D Systems makes.
[[nodiscard]] std::span<const DeviceProfile> force_dimension_profiles() noexcept;
[[nodiscard]] std::span<const DeviceProfile> openhaptics_profiles() noexcept;

/// The first profile whose words are all in the name, whatever the case; null: none.
[[nodiscard]] const DeviceProfile* profile_of(std::span<const DeviceProfile> profiles,
                                              std::string_view name);

/// Fills in what the descriptor does not know yet: what is zero in it.
void fill_in(stillgrid_device_descriptor& descriptor, const DeviceProfile& profile) noexcept;

}  // namespace stillgrid::devices
