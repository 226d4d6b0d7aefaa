#pragma once

#include <string>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/device/device_spec.hpp"
#include "proto/device_plugin.h"

namespace stillgrid::device {

/// Loads the plugin for good (its code may go on running in a thread of its own) and checks its
/// version. Every function of the table up to strerror is there; the others may be null.
///
/// Throws DeviceError.
[[nodiscard]] stillgrid_device_api negotiate_device(const std::string& plugin,
                                                    const DeviceLoop& loop);

/// Whether the table is filled in up to strerror: the others may be missing.
[[nodiscard]] bool has_every_function(const stillgrid_device_api& api) noexcept;

/// Throws DeviceError: "device 'PLUGIN': LINE".
[[noreturn]] void fail_device(DeviceFailure failure, const std::string& plugin,
                              const std::string& line);

}  // namespace stillgrid::device
