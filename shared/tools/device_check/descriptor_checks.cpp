#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>

#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"

namespace stillgrid::device_check {
namespace {

using Descriptor = stillgrid_device_descriptor;

constexpr std::array<std::pair<const char*, double Descriptor::*>, 11> kFigures = {{
    {"position_resolution_m", &Descriptor::position_resolution_m},
    {"max_force_N", &Descriptor::max_force_N},
    {"continuous_force_N", &Descriptor::continuous_force_N},
    {"nominal_stiffness_N_per_m", &Descriptor::nominal_stiffness_N_per_m},
    {"rate_hz", &Descriptor::rate_hz},
    {"motor_time_constant_s", &Descriptor::motor_time_constant_s},
    {"max_speed_m_s", &Descriptor::max_speed_m_s},
    {"max_torque_N_m", &Descriptor::max_torque_N_m},
    {"continuous_torque_N_m", &Descriptor::continuous_torque_N_m},
    {"gripper_open_m", &Descriptor::gripper_open_m},
    {"max_gripper_force_N", &Descriptor::max_gripper_force_N},
}};

Outcome check_name(const Subject& subject) {
  CheckedDevice device(subject);
  const Descriptor descriptor = device.describe();
  const std::size_t length = ::strnlen(descriptor.name, STILLGRID_DEVICE_NAME_SIZE);
  if (length == STILLGRID_DEVICE_NAME_SIZE) broken("name is not zero-terminated");
  if (length == 0) broken("name is empty");
  return {};
}

Outcome check_figures(const Subject& subject) {
  CheckedDevice device(subject);
  const Descriptor descriptor = device.describe();
  for (const auto& [name, figure] : kFigures)
    if (const double value = descriptor.*figure; !std::isfinite(value) || value < 0.0)
      broken(std::string(name) + " is " + number_text(value) +
             ", expected a finite number, 0 or more");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double min_m = descriptor.workspace_min_m[axis];
    const double max_m = descriptor.workspace_max_m[axis];
    if (!std::isfinite(min_m) || !std::isfinite(max_m) || min_m > max_m)
      broken("the workspace goes from " + number_text(min_m) + " to " + number_text(max_m) +
             " m along axis " + std::to_string(axis) + ", expected min <= max");
  }
  const bool has_both = descriptor.max_force_N > 0.0 && descriptor.continuous_force_N > 0.0;
  if (has_both && descriptor.continuous_force_N > descriptor.max_force_N)
    broken("continuous_force_N is more than max_force_N");
  return {};
}

Outcome check_freedom(const Subject& subject) {
  CheckedDevice device(subject);
  const Descriptor descriptor = device.describe();
  constexpr std::uint32_t kKnown = 2 * STILLGRID_DOF_GRIPPER - 1;
  const std::uint32_t sensed = descriptor.dof_sensed, actuated = descriptor.dof_actuated;
  if (((sensed | actuated) & ~kKnown) != 0) broken("it tells degrees of freedom that do not exist");
  if (descriptor.button_count > 32) broken("it has more buttons than bits of a state");
  if (descriptor.axis_count > STILLGRID_AXES_SIZE) broken("it has more axes than a state");
  if (sensed != 0 && descriptor.gripper_open_m > 0.0 && (sensed & STILLGRID_DOF_GRIPPER) == 0)
    broken("dof_sensed and gripper_open_m differ in whether there is a gripper");
  if (actuated != 0 && descriptor.max_gripper_force_N > 0.0 &&
      (actuated & STILLGRID_DOF_GRIPPER) == 0)
    broken("dof_actuated and max_gripper_force_N differ in whether a gripper has a motor");
  return {};
}

Outcome check_same(const Subject& subject) {
  CheckedDevice device(subject);
  const Descriptor before = device.describe();
  device.activate();
  read_ticks(device, 5);
  device.deactivate();
  const Descriptor after = device.describe();
  for (const auto& [name, figure] : kFigures)
    if (before.*figure != after.*figure)
      broken(std::string(name) + " changes from " + number_text(before.*figure) + " to " +
             number_text(after.*figure) + " over a life");
  return {};
}

Outcome check_max_read(const Subject& subject) {
  CheckedDevice device(subject);
  const std::uint64_t max_read_ns = device.describe().max_read_ns;
  constexpr std::uint64_t kTick_ns = 1'000'000;
  if (max_read_ns == 0) broken("max_read_ns is 0: nothing says how long read() may take");
  const std::string declared = std::to_string(max_read_ns) + " ns";
  if (max_read_ns >= kTick_ns)
    return {Verdict::kWarn, declared + ": a tick of 1 kHz would be over", {}};
  return {Verdict::kPass, declared, {}};
}

constexpr std::array kChecks = {
    Check{"descriptor.name", "has a name, zero-terminated", "life.order", check_name},
    Check{"descriptor.figures", "declares figures that are finite, not negative, and fit together",
          "life.order", check_figures},
    Check{"descriptor.freedom", "tells degrees of freedom, buttons, axes and a gripper that can be",
          "life.order", check_freedom},
    Check{"descriptor.same", "declares the same before and after it was active",
          "descriptor.figures", check_same},
    Check{"descriptor.max_read", "declares how long read and write may take", "life.order",
          check_max_read},
};

}  // namespace

std::span<const Check> descriptor_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
