#pragma once

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "shared/files/failing_writes.hpp"
#include "shared/realtime/stop_signal.hpp"

namespace stillgrid {

/// What a program that runs until it is told to end does first: lines on standard error that begin
/// with its name, a stop signal that is heeded, writes that fail rather than kill.
inline void prepare_daemon(const char* name) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(name));
  spdlog::set_pattern("%n: %v");
  install_stop_signal();
  make_writes_fail();
}

}  // namespace stillgrid
