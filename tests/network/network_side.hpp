#pragma once

#include <sys/types.h>

#include <stdexcept>
#include <string>

namespace stillgrid::network {

/// A right or a device that the machine does not grant; the line names it.
struct NotGranted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What keeps both sides: their holders live as long as its end for writing is open somewhere, and
/// end every process of their side when it is closed.
struct Lifeline {
  int read = -1, write = -1;
};
[[nodiscard]] Lifeline make_lifeline();

/// One of two machines, as far as programs on it can tell: a network namespace whose only way out
/// is the interface "link" (10.77.0.x/24, multicast, MTU 1500), a /dev/shm of its own, and a
/// monotonic clock that is ahead of this machine's by clock_offset_s.
struct NetworkSide {
  int tun = -1;  // IP packets that the side sends, and those that it is to receive; does not block
  pid_t holder = -1;  // a process in it, whose /proc/PID/ns/ leads there
  bool has_own_clock = false;
};

/// Rights over namespaces of our own: those of this process, or else those in a user namespace, in
/// which it is root. Returns whether it is in one. Throws NotGranted. Pre: one thread.
[[nodiscard]] bool enter_own_rights();

/// Pre: enter_own_rights(), one thread. Leaves this process in the side's network namespace. Throws
/// NotGranted.
[[nodiscard]] NetworkSide make_side(const std::string& address, double clock_offset_s,
                                    const Lifeline& lifeline);

/// This process into a network namespace that is no side's.
void leave_sides();

}  // namespace stillgrid::network
