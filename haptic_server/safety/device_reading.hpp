#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <optional>

#include "haptic_server/safety/motion_limits.hpp"
#include "haptic_server/safety/safety_flag.hpp"
#include "proto/device_plugin.h"

namespace stillgrid::safety {

/// What a device said, as far as it is believed; device frame.
struct DeviceReading {
  // Of the sample, if it came at most 10 ms late or is the same again; else of the tick.
  std::uint64_t time_ns = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::optional<Eigen::Quaterniond> orientation;  // unit
  std::uint32_t buttons = 0;
};

/// Within what a device that works stays.
struct ReadingBounds {
  Workspace workspace = {};  // as declared; an axis with min >= max has no bound
  double max_speed_m_s = std::numeric_limits<double>::infinity();  // as declared
};

/// The bounds that a descriptor declares.
[[nodiscard]] ReadingBounds reading_bounds(const stillgrid_device_descriptor& device) noexcept;

/// Why the device takes no force, as far as it tells: flags of kDeviceStatusMask, 0: it does.
/// Realtime: yes.
[[nodiscard]] std::uint32_t status_flags(const stillgrid_device_state& state) noexcept;

/// The first stage of the safety chain: which readings of a device to believe.
///
/// Not believed: no position, or one that is no number, farther than 10 m from the origin, or
/// outside the declared workspace by more than half its extent and 50 mm; an orientation that is
/// marked valid and is no unit quaternion; a stamp that goes back, or is more than 100 ms from now
/// either way; a sequence that has stood still for 100 ms under fresh stamps: encoders that stand
/// still; a leap that no hand makes, faster than 20 m/s or three times what the device declares,
/// since the sample before, and 1 mm. A leap is believed after 100 ms of readings that agree with
/// each other, when the force has faded: the device was moved while nobody looked. A slip of the
/// encoders below that bound cannot be told from a motion. Thread: the haptic loop's. Realtime:
/// yes.
class DeviceReadingCheck {
 public:
  explicit DeviceReadingCheck(const ReadingBounds& bounds = {}) : bounds_(bounds) {}

  /// The reading, or nothing where it is not believed. now_ns: of the tick, the stamps' clock.
  [[nodiscard]] std::optional<DeviceReading> check(const stillgrid_device_state& state,
                                                   std::uint64_t now_ns) noexcept;

  /// Why the last reading was not believed, a flag of kDeviceReasonMask; 0: it was.
  [[nodiscard]] std::uint32_t reason() const noexcept { return reason_; }

 private:
  struct Place {
    std::uint64_t since_ns = 0;  // the tick that saw this sample first
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  };
  [[nodiscard]] std::uint32_t fault_of_pose(const stillgrid_device_state& state) const noexcept;
  [[nodiscard]] std::uint32_t fault_of_time(const stillgrid_device_state& state,
                                            std::uint64_t now_ns) noexcept;
  [[nodiscard]] bool has_leapt(const Place& place, std::uint64_t now_ns) noexcept;

  ReadingBounds bounds_;
  std::uint32_t reason_ = 0;
  std::optional<Place> believed_;
  std::optional<Place> leapt_;     // the last reading on the far side of a leap
  std::uint64_t leapt_at_ns_ = 0;  // when readings there began
  std::uint64_t stamp_ns_ = 0;     // the newest
  std::optional<std::uint64_t> sequence_;
  std::uint64_t fresh_ns_ = 0;  // the tick that saw this sequence first
};

}  // namespace stillgrid::safety
