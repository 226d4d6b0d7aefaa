#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace stillgrid::soak {

/// What the soak publishes: snapshots of which every word follows from the writer's epoch, the
/// snapshot and the word's index, so that a reader can judge each word it was shown.
///
/// word(i) = base + i * kIndexStep, where the base stands for epoch and snapshot.
inline constexpr std::uint64_t kIndexStep = 0x9E3779B97F4A7C15ULL;

[[nodiscard]] std::uint64_t snapshot_base(std::uint64_t epoch, std::uint64_t snapshot_id) noexcept;

/// Fills a snapshot. snapshot[i] = word(i).
void fill_snapshot(std::span<std::uint64_t> snapshot, std::uint64_t base) noexcept;

/// What a gather found, before anybody knows whether the read is accepted.
struct Gathered {
  std::uint64_t base = 0;         // that the first word stands for
  std::uint64_t wrong_words = 0;  // that do not belong to it
  std::uint64_t other_base = 0;   // that the first of those stands for
};

/// Compares every word. Realtime: one relaxed load a word.
[[nodiscard]] Gathered gather_all(const std::uint64_t* payload, std::size_t words) noexcept;

/// Compares `count` words strewn over the payload, others at each tick, as a haptic tick reads some
/// spheres of many. Realtime: one relaxed load a word. Pre: words < 2^32.
[[nodiscard]] Gathered gather_strewn(const std::uint64_t* payload, std::size_t words,
                                     std::size_t count, std::uint64_t tick) noexcept;

/// Of an accepted read. Torn: a word is not of the snapshot that was reported. Mixed: torn, and
/// what was shown are words of two snapshots of this writer.
enum class Verdict { kWhole, kTorn, kMixed };
[[nodiscard]] Verdict judge(const Gathered& gathered, std::uint64_t epoch,
                            std::uint64_t snapshot_id) noexcept;

}  // namespace stillgrid::soak
