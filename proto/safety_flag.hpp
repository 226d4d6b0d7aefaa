#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace stillgrid::proto {

/// Reason codes of a tick: why the force commanded to the device is not the rendered one, in the
/// order of the safety chain, and what else was odd. Each is counted in the report. A tick whose
/// reading of the device was not believed has kFlagBadDevice and one of kDeviceReasonMask.
enum SafetyFlag : std::uint32_t {
  kFlagBadDevice = 1U << 0U,   // the device's reading was not believed: the last good one stands
  kFlagRejected = 1U << 1U,    // the rendered force was no number
  kFlagFaded = 1U << 2U,       // no fresh snapshot, or a ramp after one
  kFlagRamped = 1U << 3U,      // ramp at the start, and after any gap
  kFlagStiffness = 1U << 4U,   // contacts stiffer than the device may render
  kFlagBudget = 1U << 5U,      // more force on average than the motors bear
  kFlagWorkspace = 1U << 6U,   // at the edge of the device's workspace
  kFlagSpeed = 1U << 7U,       // faster than the device may be driven
  kFlagPassivity = 1U << 8U,   // damped by --passivity-control
  kFlagClamped = 1U << 9U,     // above the device's limit
  kFlagSlewed = 1U << 10U,     // grew or turned faster than --max-slew
  kFlagStalled = 1U << 11U,    // the first tick after a stall: zero at once
  kFlagContended = 1U << 12U,  // no fresh read in this tick
  kFlagTruncated = 1U << 13U,  // more in radius than a tick may look at
  kFlagSwept = 1U << 14U,      // a contact that was only on the way to this tick
  kFlagEnergy = 1U << 15U,     // more than the contact has taken from the hand, or would give
  // Why a reading was not believed.
  kFlagNoPosition = 1U << 16U,     // none is marked valid
  kFlagNoNumber = 1U << 17U,       // a position that is no number
  kFlagTooFar = 1U << 18U,         // a position farther than 10 m from the device's origin
  kFlagOutside = 1U << 19U,        // a position far outside the workspace that it declares
  kFlagNoOrientation = 1U << 20U,  // an orientation that is no number, or no unit quaternion
  kFlagStampBack = 1U << 21U,      // a stamp older than the one before
  kFlagStampOff = 1U << 22U,       // a stamp too far from now
  kFlagFrozen = 1U << 23U,         // fresh stamps on a sequence that stands still
  kFlagLeap = 1U << 24U,           // a motion faster than the device or any hand
  // Why a device takes no force, as it says itself.
  kFlagMotorsOff = 1U << 25U,
  kFlagNotEnabled = 1U << 26U,     // its dead-man switch is open
  kFlagNotCalibrated = 1U << 27U,  // its encoders have no reference, or are finding it
  kFlagHot = 1U << 28U,            // its motors are too hot
  kFlagDeviceFault = 1U << 29U,    // it has found a fault of its own
  kFlagCrushed = 1U << 30U,        // the tool may crush a soft body
};
inline constexpr std::array<std::string_view, 31> kSafetyFlagNames = {
    "bad_device", "rejected",   "faded",          "ramped",         "stiffness",   "budget",
    "workspace",  "speed",      "passivity",      "clamped",        "slewed",      "stalled",
    "contended",  "truncated",  "swept",          "energy",         "no_position", "no_number",
    "too_far",    "outside",    "no_orientation", "stamp_back",     "stamp_off",   "frozen",
    "leap",       "motors_off", "not_enabled",    "not_calibrated", "hot",         "device_fault",
    "crushed"};

/// All of them.
inline constexpr std::uint32_t kSafetyFlagMask = (1U << kSafetyFlagNames.size()) - 1U;

/// Those that say why a reading was not believed.
inline constexpr std::uint32_t kDeviceReasonMask = kFlagMotorsOff - kFlagNoPosition;

/// Those that say why a device takes no force.
inline constexpr std::uint32_t kDeviceStatusMask = kFlagCrushed - kFlagMotorsOff;

}  // namespace stillgrid::proto
