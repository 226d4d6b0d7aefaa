#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace stillgrid::proto {

/// Bump on any change of layout, unit or meaning of any segment; a reader refuses other versions.
inline constexpr std::uint32_t kSegmentVersion = 15;

/// "STLGRID1", little-endian. Stored last: a segment without it is not ready.
inline constexpr std::uint64_t kSegmentMagic = 0x31444952474C5453ULL;

enum class SegmentKind : std::uint32_t { kScene = 1, kTool = 2, kMouse = 3 };
enum class Clock : std::uint32_t { kMonotonic = 0, kVirtual = 1 };

/// A reader takes no place (m), velocity (m/s) or force (N) of the tool, nor place or scale of the
/// device, whose numbers are larger: published floats are 6 cm apart there, and sums of products of
/// such numbers are still far from the end of a double.
inline constexpr double kLargestNumber = 1e6;

/// No further sample, tick or publication will come.
inline constexpr std::uint64_t kNever = UINT64_MAX;

/// How a segment that a relay writes came over its network; zeros in any other. Each word is
/// atomic, relaxed: one may be newer than the next. Counts are those since the relay began.
struct RelayFigures {
  std::uint64_t relay_id;        // random, of the relay that writes; 0: none does
  std::uint64_t connected;       // 1: the other side was heard within its patience
  std::int64_t clock_offset_ns;  // the other side's clock less this one's
  std::uint64_t clock_bound_ns;  // how far that may be off
  std::uint64_t round_trip_ns;   // shortest of late; 0: none was measured, nor the clock
  std::uint64_t received;        // messages that this segment was written from
  std::uint64_t received_bytes;  // of these
  std::uint64_t lost;            // never came, or came after a newer one
  std::uint64_t repeated;        // came twice
  std::uint64_t out_of_order;    // came after a newer one
  std::uint64_t late;            // too long on their way to be shown
  std::uint64_t refused;         // a check failed
  std::uint64_t partitions;      // times that the other side fell silent and came back
  std::uint64_t longest_silence_ns;
  std::array<std::uint64_t, 2> reserved;
};
static_assert(std::is_trivially_copyable_v<RelayFigures> && sizeof(RelayFigures) == 128);

/// Opens every segment. The first two lines of 64 bytes are written before the magic and never
/// after; what follows them is atomic. Layout and lifetime: docs/protocol.md.
struct SegmentHeader {
  std::uint64_t magic;
  std::uint32_t version;  // kSegmentVersion
  SegmentKind kind;
  std::uint64_t layout_hash;  // of every struct in the segment
  std::uint64_t epoch;        // random, unlike that of any other writer
  std::uint64_t size_bytes;   // of the whole object
  std::uint64_t period_ns;    // declared: of the simulation or of the haptic loop
  Clock clock;
  std::uint32_t writer_pid;
  std::uint64_t start_ns;  // the writer's clock when it began

  std::array<std::uint64_t, 2> slot_offset;  // bytes from the segment's start, multiples of 64
  std::uint64_t payload_bytes;               // capacity of each slot's payload, a multiple of 8
  std::array<std::uint64_t, 5> reserved;

  // Atomic words: of a relay two cache lines, then one each.
  alignas(64) RelayFigures relay;
  alignas(64) std::uint64_t latest;        // snapshot last published, 0: none yet
  alignas(64) std::uint64_t heartbeat_ns;  // writer's clock at its last publication

  // Lockstep: promises about virtual time, see docs/protocol.md "Lockstep".
  alignas(64) std::uint64_t lockstep_sample_ns;  // of the next tool sample taken or published
  std::uint64_t lockstep_event_ns;               // of the next publication or tick not yet complete
};
static_assert(std::is_trivially_copyable_v<SegmentHeader>);
static_assert(sizeof(SegmentHeader) == 448 && offsetof(SegmentHeader, relay) == 128 &&
              offsetof(SegmentHeader, latest) == 256);

/// Opens every slot; the payload follows after 64 bytes.
struct alignas(64) SlotHeader {
  std::uint64_t sequence;  // 2n: snapshot n is complete; 2n - 1: being written
};
static_assert(sizeof(SlotHeader) == 64);

/// FNV-1a over a list of sizes and offsets: two builds that differ in any of them differ in the
/// hash.
template <std::size_t N>
constexpr std::uint64_t layout_hash(const std::array<std::size_t, N>& facts) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (const std::size_t fact : facts) hash = (hash ^ fact) * 0x100000001B3ULL;
  return hash;
}

}  // namespace stillgrid::proto
