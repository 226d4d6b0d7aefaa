#pragma once

#include <string>

#include "haptic_server/devices/openhaptics_library.hpp"
#include "proto/device_plugin.h"

namespace stillgrid::devices {

/// Which device the user wants: of a configuration's name, as the vendor's setup program wrote it,
/// or of a serial number; neither: the vendor's default.
struct OpenHapticsChoice {
  std::string library;  // empty: the usual names
  std::string name;
  std::string serial;
};

/// A device that is initialised in the vendor's library, disabled at the end.
class OpenHapticsLink {
 public:
  /// Throws one line: no library, another version, no device, one that another program has.
  explicit OpenHapticsLink(const OpenHapticsChoice& choice);
  ~OpenHapticsLink() { hd.disable_device(device); }

  OpenHapticsLink(const OpenHapticsLink&) = delete;
  OpenHapticsLink& operator=(const OpenHapticsLink&) = delete;

  OpenHapticsLibrary hd;
  unsigned device = kHdInvalidHandle;
  std::string model, serial, firmware, version;

  /// Fills in what the vendor's library tells, and what was published where it tells zero.
  void describe(stillgrid_device_descriptor& descriptor) const;
  /// Has the device find its reference where it can do so alone; what is left to do by hand in one
  /// line, empty: it is calibrated. at_reset: by hand, the arm is held in its reset position.
  [[nodiscard]] std::string calibrate(bool at_reset) const;
};

/// Device number index: the vendor's configurations in $GTDD_HOME/config by name, or the default
/// alone; false after the last. Throws one line: no library.
[[nodiscard]] bool list_openhaptics(const std::string& library, std::uint32_t index,
                                    stillgrid_device_listing& listing);

}  // namespace stillgrid::devices
