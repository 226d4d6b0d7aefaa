#pragma once

#include <string>

namespace stillgrid::device {

/// Returns the host's table of that name, or null. The names are stillgrid.host.log/1, and once a
/// session is set stillgrid.host.session/1.
[[nodiscard]] const void* host_extension(const char* name) noexcept;

/// Names the plugin whose lines follow: "device 'PLUGIN': LINE" in the log. The interface gives a
/// line no owner, so where a process loads two plugins both speak under the later one's name.
void set_log_owner(const std::string& plugin);

/// Sets the session for drivers that are loaded later. An empty name removes it. Thread: one.
void set_session(const std::string& session);

}  // namespace stillgrid::device
