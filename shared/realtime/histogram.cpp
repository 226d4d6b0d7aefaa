#include "shared/realtime/histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace stillgrid::realtime {
namespace {

constexpr unsigned kSubBits = 5;
constexpr std::uint64_t kSubBuckets = std::uint64_t{1} << kSubBits;

/// Values below 32 have buckets of their own; above, each power of two is cut in 32.
std::size_t bucket_of(std::uint64_t value) {
  if (value < kSubBuckets) return static_cast<std::size_t>(value);
  const auto shift = static_cast<unsigned>(std::bit_width(value)) - kSubBits - 1;
  return static_cast<std::size_t>((std::uint64_t{shift + 1} << kSubBits) +
                                  ((value >> shift) & (kSubBuckets - 1)));
}

std::uint64_t highest_in(std::size_t bucket) {
  if (bucket < kSubBuckets) return bucket;
  const std::uint64_t shift = (bucket >> kSubBits) - 1;
  const std::uint64_t lead = kSubBuckets | (bucket & (kSubBuckets - 1));
  return ((lead + 1) << shift) - 1;
}

}  // namespace

void Histogram::record(std::uint64_t value) noexcept {
  ++counts_[bucket_of(value)];
  ++count_;
  max_ = std::max(max_, value);
}

std::uint64_t Histogram::percentile(double share) const noexcept {
  const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    seen += counts_[bucket];
    if (seen >= rank && seen > 0) return std::min(highest_in(bucket), max_);
  }
  return max_;
}

double Histogram::share_above(std::uint64_t value) const noexcept {
  const auto first = counts_.begin() + static_cast<std::ptrdiff_t>(bucket_of(value) + 1);
  const std::uint64_t above = std::accumulate(first, counts_.end(), std::uint64_t{0});
  return count_ == 0 ? 0.0 : static_cast<double>(above) / static_cast<double>(count_);
}

}  // namespace stillgrid::realtime
