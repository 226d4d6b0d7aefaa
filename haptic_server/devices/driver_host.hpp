#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include "proto/device_plugin.h"

namespace stillgrid::devices {

/// Lines for the user, where the host prints any. Thread: any but the real-time one.
struct HostLog {
  const stillgrid_host_log* table = nullptr;

  void info(const std::string& line) const { write(STILLGRID_LOG_INFO, line); }
  void warn(const std::string& line) const { write(STILLGRID_LOG_WARNING, line); }

 private:
  void write(std::uint32_t severity, const std::string& line) const {
    if (table != nullptr && table->log != nullptr) table->log(severity, line.c_str());
  }
};

/// The host's period, clock, log and session, as it negotiated them.
struct HostLoop {
  std::uint64_t period_ns = 1'000'000;
  std::uint32_t clock = STILLGRID_CLOCK_MONOTONIC;
  HostLog log{};
  std::string session{};  // empty: the host has no session
};

/// A driver throws it where the fault is not an option's: the code is what the host is told.
class DriverError : public std::runtime_error {
 public:
  DriverError(std::int32_t code, const std::string& line) : std::runtime_error(line), code_(code) {}

  [[nodiscard]] std::int32_t code() const noexcept { return code_; }

 private:
  std::int32_t code_;
};

/// The last error of a device: its code and one line on it.
struct ErrorLine {
  std::int32_t code = STILLGRID_DEVICE_OK;
  std::array<char, 1024> text{};

  std::int32_t set(std::int32_t new_code, const char* line) noexcept {
    code = new_code;
    std::strncpy(text.data(), line, text.size() - 1);
    return code;
  }
};

/// The host's tick, for a driver whose own thread sets the pace.
struct HostTick {
  stillgrid_device_tick_fn tick = nullptr;
  void* context = nullptr;

  [[nodiscard]] explicit operator bool() const noexcept { return tick != nullptr; }
  /// False where the ticks are over. Realtime: the host's read, write and force between them.
  bool operator()() const noexcept { return tick(context) == 0; }
};

}  // namespace stillgrid::devices
