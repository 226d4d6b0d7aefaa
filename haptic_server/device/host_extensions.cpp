#include "haptic_server/device/host_extensions.hpp"

#include <spdlog/spdlog.h>

#include <cstdint>
#include <mutex>
#include <string_view>

#include "haptic_server/device/driver_text.hpp"
#include "proto/device_plugin.h"

namespace stillgrid::device {
namespace {

struct LogOwner {
  std::mutex mutex;
  std::string plugin;
};

/// Never destroyed: a driver's own thread may still speak while the program ends.
LogOwner& log_owner() {
  static auto* const owner = new LogOwner;
  return *owner;
}

/// Lets nothing out into the driver that called.
void log_line(std::uint32_t severity, const char* line) noexcept {
  constexpr std::size_t kLongestLine = 1024;
  try {
    LogOwner& owner = log_owner();
    const std::lock_guard one_at_a_time(owner.mutex);
    spdlog::log(severity == STILLGRID_LOG_INFO ? spdlog::level::info : spdlog::level::warn,
                "device '{}': {}", owner.plugin, line_of(line, kLongestLine));
  } catch (...) {  // NOLINT(bugprone-empty-catch): a line that cannot be printed is not printed
  }
}

constexpr stillgrid_host_log kLog{sizeof kLog, 0, log_line};

}  // namespace

const void* host_extension(const char* name) noexcept {
  return name != nullptr && std::string_view(name) == STILLGRID_HOST_LOG ? &kLog : nullptr;
}

void set_log_owner(const std::string& plugin) {
  LogOwner& owner = log_owner();
  const std::lock_guard one_at_a_time(owner.mutex);
  owner.plugin = plugin;
}

}  // namespace stillgrid::device
