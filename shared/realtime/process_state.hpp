#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace stillgrid::realtime {

/// What a library may change under the program that loaded it, in the order of ProcessState::parts.
enum class ProcessPart : std::size_t { kSignalMask, kUmask, kFolder, kSchedule };
inline constexpr std::array<std::string_view, 4> kProcessParts = {
    "the signal mask", "the umask", "the working folder", "the scheduling of its thread"};

/// These parts as text that can be compared; empty where the kernel does not tell.
struct ProcessState {
  pid_t thread = 0;
  std::array<std::string, kProcessParts.size()> parts;
};

/// As /proc tells of a thread of this process; 0: the calling one. Not for the haptic loop.
[[nodiscard]] ProcessState process_state(pid_t thread = 0);

}  // namespace stillgrid::realtime
