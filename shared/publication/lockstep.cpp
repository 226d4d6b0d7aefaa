#include "shared/publication/lockstep.hpp"

#include <sched.h>

#include <chrono>

namespace stillgrid::publication {

WaitResult wait_for_promise(const std::function<std::uint64_t()>& word, std::uint64_t value,
                            const std::function<bool()>& still_there,
                            const std::atomic<bool>& stop) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kAskEvery = std::chrono::milliseconds(10);
  auto ask_at = Clock::now() + kAskEvery;
  for (int spins = 0;; ++spins) {
    if (word() >= value) return WaitResult::kReached;
    if (spins < 200) continue;
    ::sched_yield();
    if (stop.load(std::memory_order_relaxed)) return WaitResult::kStopped;
    if (Clock::now() < ask_at) continue;
    ask_at = Clock::now() + kAskEvery;
    // A peer that ends keeps its promise first: look once more before it is called gone.
    if (!still_there() && word() < value) return WaitResult::kPeerGone;
  }
}

}  // namespace stillgrid::publication
