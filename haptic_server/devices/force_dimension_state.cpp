#include "haptic_server/devices/force_dimension_state.hpp"

#include "proto/device_plugin.h"

namespace stillgrid::devices {

static_assert(kForceDimensionStatusKnown ==
              (STILLGRID_STATUS_MOTORS_ON | STILLGRID_STATUS_ENABLED |
               STILLGRID_STATUS_CALIBRATED | STILLGRID_STATUS_FAULT));

std::uint32_t status_bits(const ForceDimensionStatus& status, bool has_active_wrist) noexcept {
  std::uint32_t bits = 0;
  const bool has_force = status[kDhdForce] != 0;
  if (status[kDhdPower] != 0 && has_force) bits |= STILLGRID_STATUS_MOTORS_ON;
  // The cause stands on after the force has come back.
  if (has_force || status[kDhdForceOffCause] != kDhdForceOffByDeadMan)
    bits |= STILLGRID_STATUS_ENABLED;
  if (status[kDhdReset] == 0 && (!has_active_wrist || status[kDhdWristInit] != 0))
    bits |= STILLGRID_STATUS_CALIBRATED;
  if (status[kDhdError] != 0) bits |= STILLGRID_STATUS_FAULT;
  return bits;
}

}  // namespace stillgrid::devices
