#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>

namespace stillgrid::soak {

/// A child process that does some work and ends. Killed (SIGKILL) at the latest when this object,
/// or its parent, ends.
class Process {
 public:
  /// Returns at once. The work's exceptions become a line on standard error and exit status 1.
  explicit Process(const std::function<void()>& work);
  ~Process() { kill(); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  [[nodiscard]] pid_t id() const noexcept { return id_; }

  /// The exit status, once it has ended; 128 and the signal's number if one ended it.
  [[nodiscard]] std::optional<int> status();

  /// Returns when the process is no more.
  void kill();

 private:
  pid_t id_ = -1;
  std::optional<int> status_;
};

}  // namespace stillgrid::soak
