#pragma once

#include <optional>
#include <string>

#include "haptic_server/devices/force_dimension_library.hpp"
#include "proto/device_plugin.h"

namespace stillgrid::devices {

/// Which of Force Dimension's devices the user wants: neither: the first that nobody has.
struct ForceDimensionChoice {
  std::string library;  // empty: the usual names
  std::optional<int> index;
  std::optional<int> serial;
};

/// A device that is open in the vendor's library, closed at the end; its motors stay as they are.
class ForceDimensionLink {
 public:
  /// Throws one line: no library, no device, one that another program has.
  explicit ForceDimensionLink(const ForceDimensionChoice& choice);
  ~ForceDimensionLink() { dhd.close(id); }

  ForceDimensionLink(const ForceDimensionLink&) = delete;
  ForceDimensionLink& operator=(const ForceDimensionLink&) = delete;

  ForceDimensionLibrary dhd;
  char id = -1;  // of the device in the library
  std::string name;
  std::string serial;  // empty: it tells none
  bool has_wrist = false, has_active_wrist = false;
  bool has_gripper = false, has_active_gripper = false;

  /// Fills in degrees of freedom and, by the device's name, what was published about it.
  void describe(stillgrid_device_descriptor& descriptor) const;
  /// Throws the line of a call that must succeed, in the vendor's words.
  void require(int result, const char* what) const;
};

/// Device number index of those that the vendor's library sees; false after the last. One that
/// another program has is listed by its number alone. Throws one line: no library.
[[nodiscard]] bool list_force_dimension(const std::string& library, std::uint32_t index,
                                        stillgrid_device_listing& listing);

}  // namespace stillgrid::devices
