#include "tests/soak/soak_snapshot.hpp"

#include "shared/double_buffer/double_buffer.hpp"

namespace stillgrid::soak {
namespace {

constexpr std::uint64_t kSnapshotIdStep = 0xD1342543DE82EF95ULL;  // odd, so it has an inverse

/// Of an odd number modulo 2^64, by Newton's method: each round doubles the bits that are right.
constexpr std::uint64_t inverse(std::uint64_t odd) {
  std::uint64_t x = odd;
  for (int i = 0; i < 6; ++i) x *= 2 - odd * x;
  return x;
}
static_assert(kSnapshotIdStep * inverse(kSnapshotIdStep) == 1);

/// Whether a base can be that of a snapshot of this writer: no soak publishes 2^40 snapshots, and a
/// word of anything else looks like one with a probability of 2^-24.
bool is_of(std::uint64_t base, std::uint64_t epoch) {
  const std::uint64_t snapshot_id = (base - epoch) * inverse(kSnapshotIdStep);
  return snapshot_id >= 1 && snapshot_id < (std::uint64_t{1} << 40U);
}

void compare(Gathered& gathered, std::uint64_t word, std::size_t index) {
  const std::uint64_t base = word - index * kIndexStep;
  if (base == gathered.base) return;
  if (gathered.wrong_words++ == 0) gathered.other_base = base;
}

}  // namespace

std::uint64_t snapshot_base(std::uint64_t epoch, std::uint64_t snapshot_id) noexcept {
  return epoch + snapshot_id * kSnapshotIdStep;
}

void fill_snapshot(std::span<std::uint64_t> snapshot, std::uint64_t base) noexcept {
  for (std::size_t i = 0; i < snapshot.size(); ++i) snapshot[i] = base + i * kIndexStep;
}

Gathered gather_all(const std::uint64_t* payload, std::size_t words) noexcept {
  Gathered gathered{.base = double_buffer::load_word(payload, 0)};
  for (std::size_t i = 1; i < words; ++i)
    compare(gathered, double_buffer::load_word(payload, i), i);
  return gathered;
}

Gathered gather_strewn(const std::uint64_t* payload, std::size_t words, std::size_t count,
                       std::uint64_t tick) noexcept {
  Gathered gathered;
  for (std::size_t i = 0; i < count; ++i) {
    // Multiples of the golden ratio, so that they lie evenly and far from each other.
    const auto share = static_cast<std::uint32_t>((tick * count + i) * 0x9E3779B1U);
    const auto index = static_cast<std::size_t>((std::uint64_t{share} * words) >> 32U);
    const std::uint64_t word = double_buffer::load_word(payload, index);
    if (i == 0) gathered.base = word - index * kIndexStep;
    compare(gathered, word, index);
  }
  return gathered;
}

Verdict judge(const Gathered& gathered, std::uint64_t epoch, std::uint64_t snapshot_id) noexcept {
  const bool is_whole =
      gathered.wrong_words == 0 && gathered.base == snapshot_base(epoch, snapshot_id);
  if (is_whole) return Verdict::kWhole;
  const bool is_mixed =
      gathered.wrong_words > 0 && is_of(gathered.base, epoch) && is_of(gathered.other_base, epoch);
  return is_mixed ? Verdict::kMixed : Verdict::kTorn;
}

}  // namespace stillgrid::soak
