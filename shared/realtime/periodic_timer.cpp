#include "shared/realtime/periodic_timer.hpp"

#include <algorithm>
#include <ctime>

namespace stillgrid::realtime {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

}  // namespace

std::uint64_t monotonic_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * kSecond_ns +
         static_cast<std::uint64_t>(now.tv_nsec);
}

PeriodicTimer::PeriodicTimer(std::uint64_t period_ns, std::uint64_t phase_ns) noexcept
    : period_ns_(period_ns),
      next_ns_(((monotonic_ns() - phase_ns) / period_ns + 1) * period_ns + phase_ns) {}

PeriodicTimer::Wake PeriodicTimer::wait(const std::atomic<bool>* stop) noexcept {
  constexpr std::uint64_t kSlice_ns = 100'000'000;
  Wake wake{.deadline_ns = next_ns_, .now_ns = monotonic_ns(), .skipped = 0};
  while (wake.now_ns < next_ns_ && !(stop != nullptr && *stop)) {
    const std::uint64_t until_ns = std::min(next_ns_, wake.now_ns + kSlice_ns);
    const timespec until{.tv_sec = static_cast<time_t>(until_ns / kSecond_ns),
                         .tv_nsec = static_cast<long>(until_ns % kSecond_ns)};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);  // EINTR: once more round
    wake.now_ns = monotonic_ns();
  }
  next_ns_ += period_ns_;
  if (wake.now_ns >= next_ns_) {
    wake.skipped = (wake.now_ns - next_ns_) / period_ns_ + 1;
    next_ns_ += wake.skipped * period_ns_;
  }
  return wake;
}

}  // namespace stillgrid::realtime
