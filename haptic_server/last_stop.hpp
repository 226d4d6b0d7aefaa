#pragma once

#include <atomic>
#include <functional>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/safety/guardian.hpp"

namespace stillgrid::haptic_server {

/// From now on a crash of this process (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS),
/// and a call of exit() that is not its own, first call emergency_stop of the device that is open,
/// once.
///
/// A crash then goes on as it would have: to a handler of before, to a core dump. It may have left
/// a lock taken that emergency_stop waits for, so the guardian is told and waits 100 ms for it.
/// After exit() end is called, which does not return. What there is no handler for, SIGKILL and
/// _exit(), is the guardian's.
///
/// open_device and guarded outlive the process's threads. Once per process, from the thread of the
/// loop, whose overflowed stack is then no hindrance.
void stop_device_at_last(std::atomic<device::Device*>& open_device, safety::GuardedState& guarded,
                         std::function<void()> end);

}  // namespace stillgrid::haptic_server
