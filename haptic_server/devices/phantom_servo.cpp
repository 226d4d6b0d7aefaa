#include "haptic_server/devices/phantom_servo.hpp"

#include <pthread.h>
#include <sched.h>

#include <chrono>
#include <utility>

namespace stillgrid::devices {
namespace {

using Clock = std::chrono::steady_clock;

void rise() {
  sched_param priority{};
  priority.sched_priority = 80;
  static_cast<void>(::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority));
}

}  // namespace

void PhantomServo::begin(std::uint64_t period_ns, std::function<bool(std::uint64_t)> work) {
  is_ended_ = false;
  thread_ = std::thread([this, period_ns, work = std::move(work)] {
    rise();
    const std::chrono::nanoseconds period(period_ns);
    for (auto next = Clock::now() + period; !is_ended_; next += period) {
      std::this_thread::sleep_until(next);
      const auto now = Clock::now();
      if (now - next >= period) next += (now - next) / period * period;
      if (!work(static_cast<std::uint64_t>(now.time_since_epoch().count()))) return;
    }
  });
}

void PhantomServo::end() noexcept {
  is_ended_ = true;
  if (thread_.joinable()) thread_.join();
}

}  // namespace stillgrid::devices
