#include "shared/realtime/realtime_thread.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cstddef>

namespace stillgrid::realtime {
namespace {

/// More stack than a tick needs, of drivers too: where a stack grows later, that is a page fault.
[[gnu::noinline]] void touch_stack() {
  constexpr std::size_t kStack = 256 * 1024, kPage = 4096;
  volatile char stack[kStack];
  for (std::size_t i = 0; i < kStack; i += kPage) stack[i] = 0;
  (void)stack[0];
}

}  // namespace

bool pin_to_cpu(int cpu) {
  if (cpu < 0 || cpu >= CPU_SETSIZE) return false;
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  return ::pthread_setaffinity_np(::pthread_self(), sizeof set, &set) == 0;
}

std::vector<std::string> make_realtime(std::optional<int> cpu) {
  std::vector<std::string> missing;
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    missing.emplace_back("locked memory (raise 'ulimit -l')");
  touch_stack();
  sched_param priority{};
  priority.sched_priority = 80;
  // What a driver starts from this thread is not real-time unless it asks to be.
  if (::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &priority) != 0)
    missing.emplace_back("SCHED_FIFO (raise 'ulimit -r' to 80)");
  if (cpu && !pin_to_cpu(*cpu)) missing.emplace_back("processor " + std::to_string(*cpu));
  return missing;
}

long page_faults() {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

}  // namespace stillgrid::realtime
