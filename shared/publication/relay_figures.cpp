#include "shared/publication/relay_figures.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

#include "shared/double_buffer/double_buffer.hpp"

namespace stillgrid::publication {
namespace {

constexpr std::size_t kWords = sizeof(proto::RelayFigures) / 8;

}  // namespace

void store_relay_figures(proto::SegmentHeader& header,
                         const proto::RelayFigures& figures) noexcept {
  const auto words = std::bit_cast<std::array<std::uint64_t, kWords>>(figures);
  auto* const place = reinterpret_cast<std::uint64_t*>(&header.relay);
  for (std::size_t i = 0; i < kWords; ++i)
    double_buffer::HardwareAtomics::store(place[i], words[i], std::memory_order_relaxed);
}

std::optional<proto::RelayFigures> load_relay_figures(const proto::SegmentHeader& live) noexcept {
  const auto figures = double_buffer::load_struct<proto::RelayFigures>(
      reinterpret_cast<const std::uint64_t*>(&live.relay));
  if (figures.relay_id == 0 || !is_sound(figures)) return std::nullopt;
  return figures;
}

bool is_sound(const proto::RelayFigures& figures) noexcept {
  const std::array times_ns{figures.clock_bound_ns, figures.round_trip_ns,
                            figures.longest_silence_ns};
  const std::array counts{figures.received, figures.received_bytes, figures.lost,
                          figures.repeated, figures.out_of_order,   figures.late,
                          figures.refused,  figures.partitions};
  constexpr auto kLongest_ns = static_cast<std::int64_t>(kLongestRelayTime_ns);
  return figures.connected <= 1 && figures.clock_offset_ns >= -kLongest_ns &&
         figures.clock_offset_ns <= kLongest_ns &&
         std::all_of(times_ns.begin(), times_ns.end(),
                     [](std::uint64_t time_ns) { return time_ns <= kLongestRelayTime_ns; }) &&
         std::all_of(counts.begin(), counts.end(),
                     [](std::uint64_t count) { return count <= kLargestRelayCount; });
}

}  // namespace stillgrid::publication
