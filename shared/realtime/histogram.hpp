#pragma once

#include <array>
#include <cstdint>

namespace stillgrid::realtime {

/// Counts of whole numbers in buckets whose width is at most 1/32 of their value, so that
/// percentiles are within 3 % whatever the range. The maximum is exact. No allocation.
class Histogram {
 public:
  /// Realtime: yes.
  void record(std::uint64_t value) noexcept;

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] std::uint64_t max() const noexcept { return max_; }

  /// The least recorded value, rounded up to its bucket, that `share` of all do not exceed; 0 when
  /// empty.
  [[nodiscard]] std::uint64_t percentile(double share) const noexcept;

  /// Of all, how many exceed `value`, in [0, 1]; those in its bucket count as if they did not. 0
  /// when empty.
  [[nodiscard]] double share_above(std::uint64_t value) const noexcept;

 private:
  static constexpr unsigned kSubBits = 5;
  static constexpr std::size_t kBuckets = (64 - kSubBits + 1) << kSubBits;
  std::array<std::uint64_t, kBuckets> counts_{};
  std::uint64_t count_ = 0;
  std::uint64_t max_ = 0;
};

}  // namespace stillgrid::realtime
