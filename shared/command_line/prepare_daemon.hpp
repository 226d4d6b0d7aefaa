#pragma once

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "shared/files/failing_writes.hpp"
#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::command_line {

/// Lines on standard error that begin with the program's name, writes that fail rather than kill.
/// A signal still ends the program at once.
inline void prepare_log(const char* name) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(name));
  spdlog::set_pattern("%n: %v");
  files::make_writes_fail();
}

/// What a program that runs until it is told to end does first: prepare_log(), and a stop signal
/// that is heeded.
inline void prepare_daemon(const char* name) {
  prepare_log(name);
  realtime::install_stop_signal();
}

}  // namespace stillgrid::command_line
