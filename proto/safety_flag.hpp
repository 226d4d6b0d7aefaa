#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace stillgrid::proto {

/// Reason codes of a tick: why the force told to the device is not the rendered one, in the order
/// of the safety chain, and what else was odd. Each is counted in the report.
enum SafetyFlag : std::uint32_t {
  kFlagBadDevice = 1U << 0U,   // the device's reading was not believed: the last good one stands
  kFlagRejected = 1U << 1U,    // the rendered force was no number
  kFlagFaded = 1U << 2U,       // no fresh image, or a ramp after one
  kFlagRamped = 1U << 3U,      // ramp at the start, and after any gap
  kFlagStiffness = 1U << 4U,   // contacts stiffer than the device may render
  kFlagBudget = 1U << 5U,      // more force on average than the motors bear
  kFlagWorkspace = 1U << 6U,   // at the edge of the device's workspace
  kFlagSpeed = 1U << 7U,       // faster than the device may be driven
  kFlagPassivity = 1U << 8U,   // damped by --passivity-control
  kFlagClamped = 1U << 9U,     // above the device's limit
  kFlagSlewed = 1U << 10U,     // changed faster than --max-slew
  kFlagStalled = 1U << 11U,    // the first tick after a stall: zero at once
  kFlagContended = 1U << 12U,  // no fresh read in this tick
  kFlagCut = 1U << 13U,        // more in reach than a tick may look at
  kFlagSwept = 1U << 14U,      // a contact that was only on the way to this tick
};
inline constexpr std::array<std::string_view, 15> kSafetyFlagNames = {
    "bad_device", "rejected", "faded",  "ramped",  "stiffness", "budget", "workspace", "speed",
    "passivity",  "clamped",  "slewed", "stalled", "contended", "cut",    "swept"};

/// All of them.
inline constexpr std::uint32_t kSafetyFlagMask = (1U << kSafetyFlagNames.size()) - 1U;

}  // namespace stillgrid::proto
