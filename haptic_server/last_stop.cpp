#include "haptic_server/last_stop.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <utility>

namespace stillgrid::haptic_server {
namespace {

constexpr std::array kCrashes = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS};

std::atomic<device::Device*>* device = nullptr;
safety::GuardedState* state = nullptr;
std::function<void()> end_after_exit;
std::array<struct sigaction, kCrashes.size()> actions_before;
std::atomic<bool> has_stopped = false;
pid_t owner = 0;  // a process that a driver forked has all of this too, and no device
alignas(16) std::array<std::byte, 65536> handler_stack;

void stop_once() {
  if (has_stopped.exchange(true)) return;
  if (device::Device* const open_device = *device) open_device->emergency_stop();
}

void on_crash(int number, siginfo_t* info, void* /*context*/) {
  const auto which = std::find(kCrashes.begin(), kCrashes.end(), number) - kCrashes.begin();
  ::sigaction(number, &actions_before[static_cast<std::size_t>(which)], nullptr);
  if (::getpid() == owner) {
    state->is_crashing = true;
    stop_once();
    state->is_crashing = false;
  }
  // What an instruction caused it causes again, but for a call that a filter refused.
  if (info->si_code <= 0 || number == SIGTRAP || number == SIGSYS) ::raise(number);
}

void on_exit() {
  if (::getpid() != owner || state->end_status != safety::GuardedState::kRuns) return;
  if (has_stopped) std::_Exit(EXIT_FAILURE);  // by emergency_stop itself
  stop_once();
  end_after_exit();
}

}  // namespace

void stop_device_at_last(std::atomic<device::Device*>& open_device, safety::GuardedState& guarded,
                         std::function<void()> end) {
  owner = ::getpid();
  device = &open_device;
  state = &guarded;
  end_after_exit = std::move(end);
  std::atexit(on_exit);

  stack_t stack{};
  stack.ss_sp = handler_stack.data();
  stack.ss_size = handler_stack.size();
  ::sigaltstack(&stack, nullptr);
  for (std::size_t i = 0; i < kCrashes.size(); ++i) {
    struct sigaction action {};
    action.sa_sigaction = on_crash;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK;
    ::sigemptyset(&action.sa_mask);
    ::sigaction(kCrashes[i], &action, &actions_before[i]);
  }
}

}  // namespace stillgrid::haptic_server
