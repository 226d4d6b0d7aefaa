#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "proto/device_plugin.h"

namespace stillgrid::device {

/// The code of a call to a driver. It is asked never to let an exception out; one that does must
/// not take us along: STILLGRID_DEVICE_E_IO.
template <class Call>
std::int32_t call_driver(const Call& call) noexcept {
  try {
    return call();
  } catch (...) {
    return STILLGRID_DEVICE_E_IO;
  }
}

/// A struct that a driver fills in, with room behind it: a driver that takes its own size for ours
/// spoils that, and is noticed.
template <class Struct>
struct Fenced {
  Struct value{};
  std::array<std::uint64_t, 16> behind{};

  Fenced() { value.struct_size = sizeof value; }

  /// To be asked after the call. Our size stays ours, whatever the driver wrote there.
  [[nodiscard]] bool holds() noexcept {
    value.struct_size = sizeof value;
    return std::all_of(behind.begin(), behind.end(), [](std::uint64_t word) { return word == 0; });
  }
};

}  // namespace stillgrid::device
