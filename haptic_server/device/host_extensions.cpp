#include "haptic_server/device/host_extensions.hpp"

#include <spdlog/spdlog.h>

#include <cstdint>
#include <list>
#include <mutex>
#include <string_view>
#include <utility>

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

const stillgrid_host_session* offered_session = nullptr;

}  // namespace

const void* host_extension(const char* name) noexcept {
  if (name == nullptr) return nullptr;
  if (std::string_view(name) == STILLGRID_HOST_LOG) return &kLog;
  return std::string_view(name) == STILLGRID_HOST_SESSION ? offered_session : nullptr;
}

void set_session(const std::string& session) {
  static auto* const kept = new std::list<std::pair<std::string, stillgrid_host_session>>;
  offered_session = nullptr;
  if (session.empty()) return;
  auto& [name, table] = kept->emplace_back(session, stillgrid_host_session{});
  table = {sizeof table, 0, name.c_str()};
  offered_session = &table;
}

void set_log_owner(const std::string& plugin) {
  LogOwner& owner = log_owner();
  const std::lock_guard one_at_a_time(owner.mutex);
  owner.plugin = plugin;
}

}  // namespace stillgrid::device
