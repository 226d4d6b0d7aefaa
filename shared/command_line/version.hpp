#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <string>

#include "proto/device_plugin.h"
#include "proto/segment_header.hpp"

namespace stillgrid::command_line {

/// The segments that a program reads or writes: "segment version 6" (docs/protocol.md).
[[nodiscard]] inline std::string segment_interface() {
  return "segment version " + std::to_string(proto::kSegmentVersion);
}

/// The drivers that a program loads: "device interface 2" (proto/device_plugin.h).
[[nodiscard]] inline std::string device_interface() {
  return "device interface " + std::to_string(STILLGRID_DEVICE_ABI);
}

/// Gives a program --version, which prints "NAME VERSION (INTERFACE, ...)" and ends it. The version
/// is that of the file VERSION; stillgrid_command_line() of CMake hands it to the program's main.
inline void add_version(CLI::App& app, std::initializer_list<std::string> interfaces = {}) {
  std::string line = app.get_name() + " " + STILLGRID_VERSION;
  const char* separator = " (";
  for (const std::string& interface : interfaces) {
    line += separator + interface;
    separator = ", ";
  }
  if (interfaces.size() > 0) line += ")";
  app.set_version_flag("--version", line, "Print the version, and end");
}

}  // namespace stillgrid::command_line
