#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
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
  void show(std::uint64_t time_ns, double position_m, double velocity_m_s) {
    const proto::SnapshotHeader before = snapshot_;
    ++snapshot_.snapshot_id;
    if (before.snapshot_id == 0) {
      position_m_.fill(position_m);
      velocity_m_s_.fill(velocity_m_s);
      snapshot_.publish_time_ns.fill(time_ns);
      snapshot_.state_time_ns.fill(time_ns);
    }
    push(position_m_, position_m);
    push(velocity_m_s_, velocity_m_s);
    const auto period_ns = static_cast<double>(time_ns - before.state_time_ns[0]);
    push(snapshot_.state_time_ns, time_ns);
    push(snapshot_.publish_time_ns, time_ns);
    snapshot_.publish_time_ns[1] =
        time_ns - static_cast<std::uint64_t>(std::llround(estimate_ * period_ns));
    snapshot_.history_count = std::min<std::uint64_t>(snapshot_.snapshot_id, proto::kHistoryLength);
    memory_ = before.snapshot_id == 0 ? at_first_snapshot()
                                      : after_switch(transition_, memory_, before, snapshot_);
  }

  /// Of predicted velocities and compliances.
  void predict(std::uint64_t period_ns) { snapshot_.prediction_ns = period_ns; }

  [[nodiscard]] SnapshotWeights weights(std::uint64_t now_ns) const {
    return snapshot_weights(transition_, memory_, snapshot_, now_ns);
  }

  /// Where the body is displayed; it moves on at its velocity.
  [[nodiscard]] double at(std::uint64_t now_ns) const {
    const SnapshotWeights shown = weights(now_ns);
    double sum_m = shown.prediction_s * velocity_m_s_[0];
    for (std::size_t i = 0; i < shown.position.size(); ++i)
      sum_m += shown.position[i] * position_m_[i];
    for (std::size_t i = 0; i < shown.velocity_s.size(); ++i)
      sum_m += shown.velocity_s[i] * velocity_m_s_[i];
    return sum_m;
  }

 private:
  template <class Array>
  static void push(Array& values, const typename Array::value_type& newest) {
    std::copy_backward(values.begin(), values.end() - 1, values.end());
    values.front() = newest;
  }

  Transition transition_;
  double estimate_;
  proto::SnapshotHeader snapshot_{};
  TransitionMemory memory_ = at_first_snapshot();
  std::array<double, proto::kHistoryLength> position_m_{}, velocity_m_s_{};
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
