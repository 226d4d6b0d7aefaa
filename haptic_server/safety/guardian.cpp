#include "haptic_server/safety/guardian.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <iterator>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "shared/realtime/exit_status.hpp"

namespace stillgrid::safety {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr timespec kPoll{0, 20'000'000}, kBetweenKills{0, 1'000'000};
/// A poll that took longer says nothing of the child: the guardian was not running either.
constexpr auto kLongestPoll = milliseconds(60);
constexpr auto kLongestCrash = milliseconds(100);
constexpr auto kLongestKill = milliseconds(1000);
constexpr auto kLongestSilence = milliseconds(2000);
constexpr auto kLongestRelease = milliseconds(10'000);

static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free &&
                  std::atomic<std::uint64_t>::is_always_lock_free,
              "shared between processes");

bool is_stop(int signal) {
  return signal == SIGINT || signal == SIGTERM || signal == SIGHUP;
}

bool is_ignored(int signal) {
  struct sigaction action {};
  ::sigaction(signal, nullptr, &action);
  return action.sa_handler == SIG_IGN;
}

/// Everything that ends a program and may be waited for, and the end of a child.
sigset_t awaited_signals() {
  sigset_t set;
  ::sigfillset(&set);
  if (is_ignored(SIGHUP)) ::sigdelset(&set, SIGHUP);  // nohup
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS, SIGTRAP, SIGTSTP,
                           SIGTTIN, SIGTTOU, SIGCONT, SIGURG, SIGWINCH})
    ::sigdelset(&set, number);
  return set;
}

GuardedState& shared_state() {
  void* const memory = ::mmap(nullptr, sizeof(GuardedState), PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED)
    throw std::system_error(errno, std::generic_category(), "memory shared with the guardian");
  return *new (memory) GuardedState;
}

/// Forks; the child gets the signals of before, and one of its own when its parent is gone.
pid_t fork_child(const sigset_t& mask, int death_signal) {
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "a process of its own");
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, death_signal);
    ::pthread_sigmask(SIG_SETMASK, &mask, nullptr);
    if (::getppid() != parent) ::raise(death_signal);
  }
  return child;
}

bool is_traced(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string key, value; status >> key && std::getline(status, value);)
    if (key == "TracerPid:") return std::strtol(value.c_str(), nullptr, 10) != 0;
  return false;
}

/// What has lasted too long, while the guardian itself was running; null as long as nothing has.
class Patience {
 public:
  [[nodiscard]] const char* lost(const GuardedState& state) {
    const auto now = Clock::now();
    const auto poll = now - std::exchange(before_, now);
    const auto passed = poll <= kLongestPoll ? poll : Clock::duration{};
    const std::uint64_t beats = state.beats.load(std::memory_order_relaxed);
    const bool is_alive = std::exchange(beats_, beats) != beats || !state.has_motors;
    silence_ = is_alive ? Clock::duration{} : silence_ + passed;
    crash_ = state.is_crashing ? crash_ + passed : Clock::duration{};
    if (crash_ >= kLongestCrash) return "its process crashed, hung and was killed";
    if (silence_ >= kLongestSilence) return "its process stood still for 2 s and was killed";
    return nullptr;
  }

 private:
  Clock::time_point before_ = Clock::now();
  std::uint64_t beats_ = 0;
  Clock::duration silence_{}, crash_{};
};

struct End {
  int status = 0;                    // of waitpid()
  const char* killed_for = nullptr;  // by the guardian
};

End outlive(pid_t child, GuardedState& state, const sigset_t& awaited) {
  End end;
  Patience patience;
  while (::waitpid(child, &end.status, WNOHANG) != child || WIFSTOPPED(end.status)) {
    // A driver that asked to be traced stops here at each signal.
    if (WIFSTOPPED(end.status))
      ::ptrace(PTRACE_DETACH, child, nullptr, WSTOPSIG(std::exchange(end.status, 0)));
    const int signal = ::sigtimedwait(&awaited, nullptr, &kPoll);
    if (is_stop(signal)) state.stop = true;
    if (signal > 0 && signal != SIGCHLD) ::kill(child, signal);
    const char* const lost = patience.lost(state);
    if (lost == nullptr || end.killed_for != nullptr || is_traced(child)) continue;
    end.killed_for = lost;
    ::kill(child, SIGKILL);
  }
  return end;
}

/// The child processes of this one: orphans that the driver left, as this one is their subreaper.
std::set<pid_t> child_processes() {
  const std::string self = std::to_string(::getpid());
  std::ifstream file("/proc/" + self + "/task/" + self + "/children");
  return {std::istream_iterator<pid_t>(file), {}};
}

/// Kills every child process but those of before; theirs come after them. Waits a second at most
/// until they have ended, for a device opens once. Returns how many were running.
std::size_t end_left_processes(const std::set<pid_t>& before) {
  std::set<pid_t> killed;
  for (const auto began = Clock::now(); Clock::now() - began < kLongestKill;) {
    bool is_left = false;
    for (const pid_t process : child_processes()) {
      if (before.contains(process) || ::waitpid(process, nullptr, WNOHANG) == process) continue;
      is_left = true;
      ::kill(process, SIGKILL);
      killed.insert(process);
    }
    if (!is_left) break;
    static_cast<void>(::nanosleep(&kBetweenKills, nullptr));
  }
  return killed.size();
}

[[noreturn]] void release(const GuardedProgram& program, const std::function<void()>& way,
                          GuardedState& state) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::signal(number, SIG_IGN);
  const rlimit no_core{0, 0};  // which would take its time
  ::setrlimit(RLIMIT_CORE, &no_core);
  try {
    way();
    state.is_released = true;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic_server: %s: while its motors were released: %s\n",
                 program.subject.c_str(), error.what());
  }
  ::_exit(realtime::kDone);
}

/// Whether one of the ways was gone to its end, in time.
bool release_motors(const GuardedProgram& program, GuardedState& state, const sigset_t& awaited,
                    const sigset_t& mask, const std::set<pid_t>& before) {
  for (const auto& way : program.releases) {
    const pid_t child = fork_child(mask, SIGKILL);
    if (child == 0) release(program, way, state);
    const auto began = Clock::now();
    while (::waitpid(child, nullptr, WNOHANG) != child) {
      static_cast<void>(::sigtimedwait(&awaited, nullptr, &kPoll));  // no stop ends this
      if (state.is_released || Clock::now() - began > kLongestRelease) ::kill(child, SIGKILL);
    }
    end_left_processes(before);
    if (state.is_released) return true;
  }
  return false;
}

std::string signal_name(int number) {
  const char* const name = ::sigabbrev_np(number);
  return name == nullptr ? "signal " + std::to_string(number) : std::string("SIG") + name;
}

bool was_killed_here(const End& end) {
  return end.killed_for != nullptr && WIFSIGNALED(end.status) && WTERMSIG(end.status) == SIGKILL;
}

/// How the child came to end, where that was not by returning; else empty.
std::string cause(const End& end, const GuardedState& state) {
  if (was_killed_here(end)) return end.killed_for;
  if (WIFSIGNALED(end.status)) {
    // A stop that came before the child caught signals.
    if (state.stop && !state.has_motors && is_stop(WTERMSIG(end.status))) return "";
    return "its process was ended by " + signal_name(WTERMSIG(end.status));
  }
  if (WEXITSTATUS(end.status) == state.end_status) return "";
  return "a call ended its process, with exit status " + std::to_string(WEXITSTATUS(end.status));
}

int exit_status(const End& end, const GuardedState& state) {
  if (was_killed_here(end)) return realtime::kDeviceFault;
  if (WIFSIGNALED(end.status)) return realtime::kSignalled + WTERMSIG(end.status);
  const int status = WEXITSTATUS(end.status);
  const bool was_meant =
      status == state.end_status && !(status == realtime::kDone && state.has_motors);
  return was_meant ? status : realtime::kDeviceFault;
}

/// Above the loop's own priority; without the right to it, as any other process.
void rise_above_loop() {
  sched_param priority{};
  priority.sched_priority = 82;
  static_cast<void>(::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &priority));
}

int guard(const GuardedProgram& program, pid_t child, GuardedState& state, const sigset_t& awaited,
          const sigset_t& mask, const std::set<pid_t>& before) {
  rise_above_loop();
  const End end = outlive(child, state, awaited);
  const auto ended = Clock::now();
  std::string line = cause(end, state);
  if (const std::size_t left = end_left_processes(before); left > 0)
    line += (line.empty() ? "" : "; ") + std::to_string(left) +
            " processes that its driver had left were killed";
  if (state.has_motors) {
    const bool is_released = release_motors(program, state, awaited, mask, before);
    const auto later = std::chrono::duration_cast<milliseconds>(Clock::now() - ended).count();
    if (line.empty()) line = "its process left its motors on";
    line += is_released ? "; its motors were released " + std::to_string(later) + " ms later"
                        : "; its motors could not be released: switch the device off";
  }
  if (!line.empty())
    std::fprintf(stderr, "haptic_server: %s: %s\n", program.subject.c_str(), line.c_str());
  return exit_status(end, state);
}

}  // namespace

void beat(GuardedState& state) noexcept {
  state.beats.fetch_add(1, std::memory_order_relaxed);
  if (::getppid() != state.guardian) state.stop.store(true, std::memory_order_relaxed);
}

int run_guarded(const GuardedProgram& program) {
  GuardedState& state = shared_state();
  std::signal(SIGCHLD, SIG_DFL);
  const sigset_t awaited = awaited_signals();
  sigset_t mask;
  ::pthread_sigmask(SIG_BLOCK, &awaited, &mask);
  const std::set<pid_t> before = child_processes();  // of a shell that exec'd this program
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  state.guardian = ::getpid();
  const pid_t child = fork_child(mask, SIGTERM);
  if (child == 0) {
    const int status = program.work(state);
    state.end_status = status;
    std::exit(status);
  }
  const int status = guard(program, child, state, awaited, mask, before);
  ::prctl(PR_SET_CHILD_SUBREAPER, 0);
  ::munmap(&state, sizeof state);
  ::pthread_sigmask(SIG_SETMASK, &mask, nullptr);
  return status;
}

}  // namespace stillgrid::safety
