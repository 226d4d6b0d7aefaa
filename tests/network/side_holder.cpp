#include "tests/network/side_holder.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

namespace stillgrid::network {
namespace {

/// What could not be had, or empty.
std::string own_shared_memory() {
  if (::unshare(CLONE_NEWNS) < 0) return std::string("a mount namespace: ") + std::strerror(errno);
  if (::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) < 0 ||
      ::mount("tmpfs", "/dev/shm", "tmpfs", MS_NOSUID | MS_NODEV, "mode=1777") < 0)
    return std::string("a /dev/shm of its own: ") + std::strerror(errno);
  return {};
}

/// The same of a clock.
std::string own_clock(double offset_s) {
  if (offset_s == 0.0) return {};
  const auto failed = [] { return std::string("a clock of its own: ") + std::strerror(errno); };
  const double whole_s = std::floor(offset_s);
  const std::string offset = std::to_string(static_cast<long long>(whole_s)) + " " +
                             std::to_string(std::llround((offset_s - whole_s) * 1e9)) + "\n";
  const std::string text = "monotonic " + offset + "boottime " + offset;
  if (::unshare(CLONE_NEWTIME) < 0) return failed();
  const int offsets = ::open("/proc/self/timens_offsets", O_WRONLY | O_CLOEXEC);
  if (offsets < 0 || ::write(offsets, text.data(), text.size()) < 0) return failed();
  const int clock = ::open("/proc/self/ns/time_for_children", O_RDONLY | O_CLOEXEC);
  if (clock < 0 || ::setns(clock, CLONE_NEWTIME) < 0) return failed();
  return {};
}

std::string network_of(const std::string& process) {
  std::error_code none;
  return std::filesystem::read_symlink("/proc/" + process + "/ns/net", none).string();
}

/// Sends SIGKILL to every other process of this network namespace; false if there was none.
bool kill_others() {
  const std::string own = std::to_string(::getpid()), network = network_of("self");
  bool is_any = false;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (!std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; }))
      continue;
    if (name == own || network_of(name) != network) continue;
    ::kill(std::atoi(name.c_str()), SIGKILL);
    is_any = true;
  }
  return is_any;
}

void wait_for_end(int lifeline) {
  char byte = 0;
  while (::read(lifeline, &byte, 1) < 0 && errno == EINTR) {
  }
}

[[noreturn]] void hold(double clock_offset_s, const Lifeline& lifeline, const Lifeline& told) {
  ::close(lifeline.write);
  ::close(told.read);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_IGN);
  ::prctl(PR_SET_NAME, "link_side");
  std::string wrong = own_shared_memory();
  if (wrong.empty()) wrong = own_clock(clock_offset_s);
  if (::write(told.write, wrong.data(), wrong.size()) < 0) ::_exit(1);
  ::close(told.write);
  if (wrong.empty()) {
    wait_for_end(lifeline.read);
    while (kill_others()) ::usleep(1'000);  // what one of them had just started too
  }
  ::_exit(0);
}

}  // namespace

pid_t start_holder(double clock_offset_s, const Lifeline& lifeline) {
  const Lifeline told = make_lifeline();
  const pid_t holder = ::fork();
  if (holder == 0) hold(clock_offset_s, lifeline, told);
  ::close(told.write);
  std::array<char, 256> text{};
  const ssize_t size = ::read(told.read, text.data(), text.size());
  ::close(told.read);
  if (holder > 0 && size == 0) return holder;
  if (holder > 0) ::waitpid(holder, nullptr, 0);
  throw NotGranted(size > 0 ? std::string(text.data(), static_cast<std::size_t>(size))
                            : "a process for a side");
}

}  // namespace stillgrid::network
