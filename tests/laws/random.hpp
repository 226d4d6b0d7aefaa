#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>

namespace stillgrid::laws {

/// Numbers of a seed, the same on every machine: SplitMix64 [Steele, Lea and Flood 2014]. The
/// standard library's distributions differ between implementations.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  [[nodiscard]] std::uint64_t bits() noexcept {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t mixed = state_;
    mixed = (mixed ^ (mixed >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    mixed = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EBULL;
    return mixed ^ (mixed >> 31U);
  }
  /// From low to high, evenly.
  [[nodiscard]] double between(double low, double high) noexcept {
    return low + (high - low) * static_cast<double>(bits() >> 11U) * 0x1p-53;
  }
  /// From low to high, evenly by their logarithm. Pre: both > 0.
  [[nodiscard]] double over_decades(double low, double high) noexcept {
    return std::exp(between(std::log(low), std::log(high)));
  }
  /// 0 to count - 1. Pre: count > 0.
  [[nodiscard]] std::size_t index(std::size_t count) noexcept { return bits() % count; }
  [[nodiscard]] bool chance(double probability) noexcept { return between(0.0, 1.0) < probability; }
  [[nodiscard]] std::string_view one_of(std::initializer_list<std::string_view> names) noexcept {
    return names.begin()[index(names.size())];
  }

 private:
  std::uint64_t state_;
};

}  // namespace stillgrid::laws
