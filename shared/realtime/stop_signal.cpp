#include "shared/realtime/stop_signal.hpp"

#include <csignal>

namespace stillgrid::realtime {
namespace {

std::atomic<bool> own_stop = false;
std::atomic<bool>* stop = &own_stop;
std::atomic<int> rare_signal = 0;
static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");

}  // namespace

const std::atomic<bool>& stop_requested() noexcept {
  return *stop;
}

void share_stop(std::atomic<bool>& shared) noexcept {
  stop = &shared;
}

void install_stop_signal() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop->store(true, std::memory_order_relaxed); };
  ::sigemptyset(&action.sa_mask);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  struct sigaction before {};
  ::sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);  // nohup
}

void install_rare_stop_signals() {
  struct sigaction action {};
  action.sa_handler = [](int number) {
    int none = 0;
    rare_signal.compare_exchange_strong(none, number, std::memory_order_relaxed);
    stop->store(true, std::memory_order_relaxed);
  };
  ::sigemptyset(&action.sa_mask);
  const auto heed = [&action](int number) {
    struct sigaction before {};
    ::sigaction(number, nullptr, &before);
    if (before.sa_handler == SIG_DFL) ::sigaction(number, &action, nullptr);
  };
  for (const int number :
       {SIGQUIT, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGXCPU, SIGIO, SIGPWR, SIGSTKFLT})
    heed(number);
  for (int number = SIGRTMIN; number <= SIGRTMAX; ++number) heed(number);
}

int rare_stop_signal() noexcept {
  return rare_signal.load(std::memory_order_relaxed);
}

}  // namespace stillgrid::realtime
