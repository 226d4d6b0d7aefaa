#pragma once

#include <string>

namespace stillgrid::device {

/// Which device this is, in the driver's words; empty where it did not say. One line of UTF-8 each.
struct DeviceIdentity {
  std::string serial, firmware;
  std::string driver;  // name and version of the driver itself
};

}  // namespace stillgrid::device
