#include "shared/tools/scene_relay/clock_offset.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::scene_relay {
namespace {

/// Beyond which a stamp is no clock's: 73 years. A stamp and an offset have a sum.
constexpr std::uint64_t kLatest_ns = std::uint64_t{1} << 61U;
/// By how much the offset in use may lie off what is known now, and yet follow it slowly.
constexpr std::uint64_t kLongestSlew_ns = 20'000'000;
/// A round trip that takes longer tells nothing.
constexpr std::uint64_t kLongestTrip_ns = 10'000'000'000;
/// Of which the offset may follow at once; after a longer pause it goes on from there.
constexpr std::uint64_t kLongestStep_ns = 500'000'000;

/// Halves of whole nanoseconds.
constexpr std::uint64_t kRounding_ns = 2;

std::uint64_t drift_ns(std::uint64_t over_ns) {
  return static_cast<std::uint64_t>(ClockOffset::kDrift * static_cast<double>(over_ns));
}

std::int64_t between(std::uint64_t from_ns, std::uint64_t to_ns) {
  return static_cast<std::int64_t>(to_ns) - static_cast<std::int64_t>(from_ns);
}

std::uint64_t moved(std::uint64_t time_ns, std::int64_t by_ns) {
  if (time_ns > kLatest_ns) return time_ns;
  const std::int64_t sum = static_cast<std::int64_t>(time_ns) + by_ns;
  return sum > 0 ? static_cast<std::uint64_t>(sum) : 0;
}

}  // namespace

std::uint64_t ClockOffset::Kept::bound_ns(std::uint64_t now_ns) const noexcept {
  return error_ns + drift_ns(now_ns - std::min(now_ns, at_ns));
}

bool ClockOffset::add(const Exchange& exchange) noexcept {
  const std::uint64_t sent_ns = exchange.sent_ns, received_ns = exchange.received_ns;
  const std::uint64_t other_received_ns = exchange.other_received_ns;
  const std::uint64_t other_sent_ns = exchange.other_sent_ns;
  if (std::max({sent_ns, other_received_ns, other_sent_ns, received_ns}) > kLatest_ns) return false;
  const std::int64_t trip_ns =
      between(sent_ns, received_ns) - between(other_received_ns, other_sent_ns);
  if (received_ns < sent_ns || other_sent_ns < other_received_ns || trip_ns < 0 ||
      static_cast<std::uint64_t>(trip_ns) > kLongestTrip_ns || received_ns < at_ns_)
    return false;
  const std::int64_t there_ns = between(sent_ns, other_received_ns);
  const std::int64_t back_ns = between(received_ns, other_sent_ns);
  // Clocks that drift make the trip look shorter, and the offset another at its end.
  const auto round_trip_ns = static_cast<std::uint64_t>(trip_ns);
  const Kept now{.offset_ns = there_ns / 2 + back_ns / 2,
                 .round_trip_ns = round_trip_ns,
                 .error_ns = round_trip_ns / 2 + drift_ns(received_ns - sent_ns) + kRounding_ns,
                 .at_ns = received_ns};
  // No two truths: one of the clocks stood still or was set.
  const auto apart_ns = static_cast<std::uint64_t>(std::abs(now.offset_ns - offset_ns_));
  const std::uint64_t used_bound_ns = bound_ns_ + drift_ns(received_ns - at_ns_);
  if (count_ > 0 && apart_ns > now.error_ns + used_bound_ns + 1'000'000) count_ = 0;
  if (count_ == 0) next_ = 0;
  kept_[next_] = now;
  next_ = (next_ + 1) % kKept;
  count_ = std::min(count_ + 1, kKept);
  const Kept& best =
      *std::min_element(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(count_),
                        [&](const Kept& a, const Kept& b) {
                          return a.bound_ns(received_ns) < b.bound_ns(received_ns);
                        });
  const std::uint64_t step_ns = std::min(received_ns - at_ns_, kLongestStep_ns);
  const auto most_ns = static_cast<std::int64_t>(kSlew * static_cast<double>(step_ns)) + 1;
  const std::int64_t by_ns = best.offset_ns - offset_ns_;
  // What was learnt of a worse link is not held on to: it would make every age wrong for minutes.
  const bool is_settling = count_ <= kEnough || static_cast<std::uint64_t>(std::abs(by_ns)) >
                                                    best.bound_ns(received_ns) + kLongestSlew_ns;
  offset_ns_ += is_settling ? by_ns : std::clamp(by_ns, -most_ns, most_ns);
  bound_ns_ = best.bound_ns(received_ns) +
              static_cast<std::uint64_t>(std::abs(best.offset_ns - offset_ns_));
  round_trip_ns_ = best.round_trip_ns;
  at_ns_ = received_ns;
  return true;
}

std::uint64_t ClockOffset::to_ours(std::uint64_t other_ns) const noexcept {
  return moved(other_ns, -offset_ns_);
}

std::uint64_t ClockOffset::to_others(std::uint64_t our_ns) const noexcept {
  return moved(our_ns, offset_ns_);
}

}  // namespace stillgrid::scene_relay
