#include "shared/tools/scene_relay/clock_offset.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::scene_relay {
namespace {

/// Beyond which a stamp is no clock's: 290 years in all.
constexpr std::uint64_t kLatest_ns = std::uint64_t{1} << 62U;
/// A round trip that takes longer tells nothing.
constexpr std::uint64_t kLongestTrip_ns = 10'000'000'000;

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
  const double since_ns = static_cast<double>(now_ns - std::min(now_ns, at_ns));
  return round_trip_ns / 2 + static_cast<std::uint64_t>(kDrift * since_ns);
}

bool ClockOffset::add(const Exchange& exchange) noexcept {
  const auto [sent_ns, other_received_ns, other_sent_ns, received_ns] = exchange;
  if (std::max({sent_ns, other_received_ns, other_sent_ns, received_ns}) > kLatest_ns) return false;
  const std::int64_t trip_ns =
      between(sent_ns, received_ns) - between(other_received_ns, other_sent_ns);
  if (received_ns < sent_ns || other_sent_ns < other_received_ns || trip_ns < 0 ||
      static_cast<std::uint64_t>(trip_ns) > kLongestTrip_ns || received_ns < at_ns_)
    return false;
  const std::int64_t there_ns = between(sent_ns, other_received_ns);
  const std::int64_t back_ns = between(received_ns, other_sent_ns);
  const Kept now{there_ns / 2 + back_ns / 2, static_cast<std::uint64_t>(trip_ns), received_ns};
  // No two truths: one of the clocks stood still or was set.
  const std::uint64_t apart_ns = static_cast<std::uint64_t>(std::abs(now.offset_ns - offset_ns_));
  if (count_ > 0 && apart_ns > now.bound_ns(received_ns) + bound_ns_ + 1'000'000) count_ = 0;
  if (count_ == 0) next_ = 0;
  kept_[next_] = now;
  next_ = (next_ + 1) % kKept;
  count_ = std::min(count_ + 1, kKept);
  const Kept& best =
      *std::min_element(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(count_),
                        [&](const Kept& a, const Kept& b) {
                          return a.bound_ns(received_ns) < b.bound_ns(received_ns);
                        });
  const auto most_ns =
      static_cast<std::int64_t>(kSlew * static_cast<double>(received_ns - at_ns_)) + 1;
  const std::int64_t by_ns = best.offset_ns - offset_ns_;
  const bool is_settling = count_ <= kEnough;
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
