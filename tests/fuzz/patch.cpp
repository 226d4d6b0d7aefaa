#include "tests/fuzz/patch.hpp"

#include <array>
#include <limits>

namespace stillgrid::fuzz {
namespace {

template <class Float>
Float odd_number(std::uint64_t choice) {
  using Limits = std::numeric_limits<Float>;
  constexpr Float kBig = std::is_same_v<Float, float> ? Float(1e30) : Float(1e200);
  constexpr std::array kOdd{Limits::quiet_NaN(),
                            Limits::infinity(),
                            -Limits::infinity(),
                            Limits::max(),
                            Limits::lowest(),
                            Limits::min(),
                            Limits::denorm_min(),
                            Float(0),
                            -Float(0),
                            Float(1),
                            Float(-1),
                            kBig,
                            -kBig,
                            Float(1) / kBig,
                            Float(1e4),
                            Float(-1e4),
                            Float(1e9),
                            Float(-1e9)};
  return kOdd[choice % kOdd.size()];
}

template <class T>
void write(std::span<std::byte> region, std::size_t place, T value) {
  if (region.size() < sizeof value) return;
  std::memcpy(&region[std::min(place, region.size() - sizeof value)], &value, sizeof value);
}

/// Adds a small signed step to the number that stands there.
template <class T>
void step(std::span<std::byte> region, std::size_t place, std::uint64_t value) {
  if (region.size() < sizeof(T)) return;
  const std::size_t at = std::min(place, region.size() - sizeof(T));
  T word{};
  std::memcpy(&word, &region[at], sizeof word);
  const auto by = static_cast<std::int64_t>((value % 256) ^ 128) - 128;
  write(region, at, static_cast<T>(word + static_cast<T>(by)));
}

}  // namespace

void apply_patch(std::span<const std::span<std::byte>> regions, FuzzInput& input) {
  const std::span<std::byte> region = regions[input.take<std::uint8_t>() % regions.size()];
  const auto kind = input.take<std::uint8_t>();
  const auto place_words = input.take<std::uint16_t>();
  const auto value = input.take<std::uint64_t>();
  if (region.size() < 4) return;
  const std::size_t place = place_words % (region.size() / 4) * 4;
  switch (kind % 8) {
    case 0:
      return write(region, place, static_cast<std::uint32_t>(value));
    case 1:
      return write(region, place, value);
    case 2:
      return step<std::uint32_t>(region, place, value);
    case 3:
      return step<std::uint64_t>(region, place, value);
    case 4:
      return write(region, place, std::uint32_t{static_cast<std::uint8_t>(value)});
    case 5:
      return write(region, place, odd_number<float>(value));
    case 6:
      return write(region, place, odd_number<double>(value));
    default:
      return write(region, place, static_cast<std::uint8_t>(value));
  }
}

void apply_patches(std::span<const std::span<std::byte>> regions, FuzzInput& input) {
  const std::uint32_t count = input.take<std::uint8_t>() % 16U;
  for (std::uint32_t i = 0; i < count && !input.is_empty(); ++i) apply_patch(regions, input);
}

}  // namespace stillgrid::fuzz
