#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "proto/device_plugin.h"

namespace stillgrid {

/// What a device said, as far as it is believed; device frame.
struct DeviceReading {
  // Of the sample, if it came at most 10 ms late or is the same again; else of the tick.
  std::uint64_t time_ns = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::optional<Eigen::Quaterniond> orientation;  // unit
  std::uint32_t buttons = 0;
};

/// The first stage of the safety chain: which readings of a device to believe.
///
/// Not believed: no position, or one that is no number or farther than 10 m from the origin; a
/// stamp that goes back, or is more than 100 ms from now either way: encoders that stand still; a
/// leap that no hand makes, faster than 20 m/s. A leap is believed after 100 ms of readings that
/// agree with each other, when the force has faded: the device was moved while nobody looked.
/// Thread: the haptic loop's. Realtime: yes.
class DeviceReadingCheck {
 public:
  /// The reading, or nothing where it is not believed. now_ns: of the tick, the stamps' clock.
  [[nodiscard]] std::optional<DeviceReading> check(const stillgrid_device_state& state,
                                                   std::uint64_t now_ns) noexcept;

 private:
  struct Place {
    std::uint64_t tick_ns = 0;
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  };

  std::optional<Place> believed_;
  std::optional<Place> leapt_;     // the last reading on the far side of a leap
  std::uint64_t leapt_at_ns_ = 0;  // when readings there began
  std::uint64_t stamp_ns_ = 0;     // the newest
};

}  // namespace stillgrid
