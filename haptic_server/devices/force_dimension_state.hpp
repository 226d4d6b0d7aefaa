#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace stillgrid::devices {

/// dhdGetStatus() fills in 16 or 17 numbers, by version; a margin for those to come.
using ForceDimensionStatus = std::array<int, 32>;

/// Places in a status, as published.
enum ForceDimensionStatusIndex : std::size_t {
  kDhdPower = 0,
  kDhdConnected = 1,
  kDhdReset = 3,
  kDhdForce = 5,
  kDhdError = 9,
  kDhdWristInit = 12,
  kDhdForceOffCause = 14,
};
constexpr int kDhdForceOffByDeadMan = 6;

/// The bits of STILLGRID_STATUS_... that a status tells.
constexpr std::uint32_t kForceDimensionStatusKnown = 1U | 2U | 4U | 16U;

/// Status bits of a device: motors on while it has power and is in force mode, or only its dead-man
/// took the force, which is then not enabled; calibrated unless it waits in reset or an active
/// wrist has no reference; fault where its controller says so. Realtime: yes.
[[nodiscard]] std::uint32_t status_bits(const ForceDimensionStatus& status,
                                        bool has_active_wrist) noexcept;

}  // namespace stillgrid::devices
