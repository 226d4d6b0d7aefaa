#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace stillgrid::scene_viewer {

/// Words joined by spaces, those quoted that a shell would not take as they are; empty where a word
/// holds a character that controls a terminal.
[[nodiscard]] std::string shell_line(const std::vector<std::string>& words);

/// The command that started the process which writes a segment, to start it again when it is dead.
/// Thread: one.
class WriterCommand {
 public:
  explicit WriterCommand(std::string_view hand_session);

  /// Asks the system once for each writer. Pre: it lives.
  void look(std::uint64_t epoch, std::uint32_t writer_pid);

  /// For a shell. Empty where the system does not tell, or tells of a command without the session's
  /// name: that of another process, where writer and viewer count processes apart.
  [[nodiscard]] const std::string& line() const noexcept { return line_; }

 private:
  std::string session_;
  std::uint64_t epoch_ = 0;
  std::string line_;
};

}  // namespace stillgrid::scene_viewer
