#pragma once

#include <functional>

namespace stillgrid::publication {

/// Another process that does some work until it is killed (SIGKILL), at the latest when this
/// object ends. It runs no test and writes nothing.
class OtherProcess {
 public:
  /// Says that the work has come as far as the test needs it.
  using Ready = std::function<void()>;

  /// Returns when the work is ready, or has ended without being so: then was_ready() is false.
  explicit OtherProcess(const std::function<void(const Ready&)>& work);
  ~OtherProcess() { kill(); }
  OtherProcess(const OtherProcess&) = delete;
  OtherProcess& operator=(const OtherProcess&) = delete;

  [[nodiscard]] bool was_ready() const noexcept { return was_ready_; }

  /// Returns when the process is no more.
  void kill();

  /// For the work: waits to be killed.
  [[noreturn]] static void rest();

 private:
  int pid_ = -1;
  bool was_ready_ = false;
};

}  // namespace stillgrid::publication
