#pragma once

#include <chrono>
#include <cstring>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "proto/device_plugin.h"

namespace stillgrid::devices {

/// The lines that drivers log.
struct DriverLog {
  std::mutex mutex;
  std::vector<std::string> lines;

  [[nodiscard]] bool has(std::string_view word) {
    const std::scoped_lock lock(mutex);
    for (const std::string& line : lines)
      if (line.find(word) != std::string::npos) return true;
    return false;
  }
};
inline DriverLog driver_log;

/// A host that keeps the lines of a driver.
inline const void* logging_host(const char* name) {
  static const stillgrid_host_log log{sizeof log, 0, [](std::uint32_t, const char* line) {
                                        const std::scoped_lock lock(driver_log.mutex);
                                        driver_log.lines.emplace_back(line);
                                      }};
  return std::strcmp(name, STILLGRID_HOST_LOG) == 0 ? &log : nullptr;
}

/// Tries until the condition holds, for seconds if it must.
template <class Condition>
bool wait_until(const Condition& condition) {
  for (int n = 0; n < 20'000; ++n) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

}  // namespace stillgrid::devices
