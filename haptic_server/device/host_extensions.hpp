#pragma once

#include <string>

namespace stillgrid::device {

/// The tables that the host offers a driver by name: stillgrid.host.log/1; null for any other name.
[[nodiscard]] const void* host_extension(const char* name) noexcept;

/// Names the plugin whose lines follow: "device 'PLUGIN': LINE" in the log. The interface gives a
/// line no owner, so where a process loads two plugins both speak under the later one's name.
void set_log_owner(const std::string& plugin);

}  // namespace stillgrid::device
