#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

namespace stillgrid::publication {

enum class WaitResult { kReached, kStopped, kPeerGone };

/// Waits until a word of the peer's segment reaches `value`: one promise of lockstep, see
/// docs/protocol.md. Not real-time: virtual time waits for nobody.
///
/// word() loads the promise, or 0 while there is no peer; still_there() is asked about every 10 ms
/// and may reattach; stop ends the wait.
WaitResult wait_for_promise(const std::function<std::uint64_t()>& word, std::uint64_t value,
                            const std::function<bool()>& still_there,
                            const std::atomic<bool>& stop);

}  // namespace stillgrid::publication
