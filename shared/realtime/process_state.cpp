#include "shared/realtime/process_state.hpp"

#include <sched.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <system_error>

namespace stillgrid::realtime {

ProcessState process_state(pid_t thread) {
  ProcessState state;
  state.thread = thread != 0 ? thread : ::gettid();
  const auto part = [&state](ProcessPart which) -> std::string& {
    return state.parts[static_cast<std::size_t>(which)];
  };
  std::ifstream status("/proc/self/task/" + std::to_string(state.thread) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("SigBlk:")) part(ProcessPart::kSignalMask) = line;
    if (line.starts_with("Umask:")) part(ProcessPart::kUmask) = line;
  }
  std::error_code failure;
  part(ProcessPart::kFolder) = std::filesystem::current_path(failure).string();
  sched_param priority{};
  const int policy = ::sched_getscheduler(state.thread);
  if (policy >= 0 && ::sched_getparam(state.thread, &priority) == 0)
    part(ProcessPart::kSchedule) =
        std::to_string(policy) + " " + std::to_string(priority.sched_priority);
  return state;
}

}  // namespace stillgrid::realtime
