#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "shared/display/transition.hpp"

namespace stillgrid::display {

/// A body on a line, shown by a transition as a renderer shows a sphere, but in double precision.
class SnapshotHistory {
 public:
  /// estimate: the period that the stamps tell, over the true one.
  explicit SnapshotHistory(Transition transition, double estimate = 1.0)
      : transition_(transition), estimate_(estimate) {}

  /// Snapshot of time_ns, published at once. Times must grow.
  void show(std::uint64_t time_ns, double position_m) {
    const std::uint64_t before_ns =
        snapshot_.snapshot_id == 0 ? time_ns : snapshot_.state_time_ns[0];
    ++snapshot_.snapshot_id;
    before_m_ = snapshot_.snapshot_id == 1 ? position_m : newest_m_;
    newest_m_ = position_m;
    snapshot_.state_time_ns = {time_ns, before_ns};
    const auto period_ns = static_cast<double>(time_ns - before_ns);
    snapshot_.publish_time_ns = {
        time_ns, time_ns - static_cast<std::uint64_t>(std::llround(estimate_ * period_ns))};
    snapshot_.history_count = std::min<std::uint64_t>(snapshot_.snapshot_id, proto::kHistoryLength);
  }

  /// Where the body is displayed.
  [[nodiscard]] double at(std::uint64_t now_ns) const {
    const double alpha = snapshot_weights(transition_, snapshot_, now_ns).alpha;
    return alpha * newest_m_ + (1.0 - alpha) * before_m_;
  }

 private:
  Transition transition_;
  double estimate_;
  proto::SnapshotHeader snapshot_{};
  double newest_m_ = 0.0, before_m_ = 0.0;
};

/// Instants of switches from `first_ns` on, their periods uniform within +-jitter of the period.
inline std::vector<std::uint64_t> switch_times_ns(std::size_t count, std::uint64_t period_ns,
                                                  double jitter, unsigned seed,
                                                  std::uint64_t first_ns = 0) {
  std::mt19937_64 generator(seed);
  std::vector<std::uint64_t> times{first_ns};
  while (times.size() < count) {
    // Not a distribution of the library, whose draws are not the same everywhere.
    const double unit = static_cast<double>(generator() >> 11U) * 0x1p-53;
    const double period = static_cast<double>(period_ns) * (1.0 + jitter * (2.0 * unit - 1.0));
    times.push_back(times.back() + static_cast<std::uint64_t>(std::llround(period)));
  }
  return times;
}

}  // namespace stillgrid::display
