#include "haptic_server/devices/force_dimension_state.hpp"

#include "proto/device_plugin.h"

namespace stillgrid::devices {

static_assert(kForceDimensionStatusKnown == (STILLGRID_STATUS_MOTORS_ON | STILLGRID_STATUS_ENABLED |
                                             STILLGRID_STATUS_CALIBRATED | STILLGRID_STATUS_FAULT));

std::uint32_t status_bits(const ForceDimensionStatus& status, bool has_active_wrist) noexcept {
  std::uint32_t bits = 0;
  const bool has_force = status[kDhdForce] != 0;
  // The cause stands on after the force has come back.
  const bool is_let_go = !has_force && status[kDhdForceOffCause] == kDhdForceOffByDeadMan;
  if (status[kDhdPower] != 0 && (has_force || is_let_go)) bits |= STILLGRID_STATUS_MOTORS_ON;
  if (!is_let_go) bits |= STILLGRID_STATUS_ENABLED;
  if (status[kDhdReset] == 0 && (!has_active_wrist || status[kDhdWristInit] != 0))
    bits |= STILLGRID_STATUS_CALIBRATED;
  if (status[kDhdError] != 0) bits |= STILLGRID_STATUS_FAULT;
  return bits;
}

}  // namespace stillgrid::devices
