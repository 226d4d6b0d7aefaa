#include "sim_server/lockstep_schedule.hpp"

#include <algorithm>
#include <utility>

#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::sim_server {

LockstepSchedule::LockstepSchedule(double period_s, double jitter, std::uint64_t seed,
                                   double latency_s, double first_share)
    : period_s_(period_s),
      share_(first_share),
      latency_ns_(realtime::to_ns(latency_s)),
      random_(seed),
      spread_(-jitter, jitter) {}

ScheduledSnapshot LockstepSchedule::next() {
  last_.step_ns =
      realtime::to_ns(std::exchange(share_, 1.0) * period_s_ * (1.0 + spread_(random_)));
  last_.state_ns += last_.step_ns;
  last_.sample_ns = std::max(last_.state_ns, last_.publish_ns);
  last_.publish_ns = last_.sample_ns + latency_ns_;
  return last_;
}

}  // namespace stillgrid::sim_server
