#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <thread>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/tool_placement.hpp"

namespace stillgrid::haptic_server {

/// Reads orders from a file or named pipe as they come, KEY=VALUE a line, in a thread of its own.
/// Orders "tool.KEY" go to the tool, all others to the device. An order that is refused is a line
/// for the user, and the run goes on.
class CommandReader {
 public:
  /// Opens the file. Throws std::runtime_error, one line, where it cannot be read.
  CommandReader(const std::filesystem::path& file, device::Device& device, ToolOrders& tool);
  ~CommandReader();

  CommandReader(const CommandReader&) = delete;
  CommandReader& operator=(const CommandReader&) = delete;

 private:
  void read_lines(const std::stop_token& end);
  void take_end(bool may_obey);
  void obey(const std::string& line);
  void refuse(const std::string& line, const std::string& why);

  device::Device& device_;
  ToolOrders& tool_;
  std::string name_;
  int file_;
  bool is_file_ = false;     // not a pipe: what stands at its end may be a whole line
  bool was_at_end_ = false;  // a moment ago, and nothing has come since
  std::uint64_t refusals_ = 0;
  std::string pending_;  // of a line whose end has not come
  std::jthread thread_;  // last: joined before what it uses is gone
};

}  // namespace stillgrid::haptic_server
