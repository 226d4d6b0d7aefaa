#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

#include "shared/realtime/histogram.hpp"

namespace stillgrid::soak {

/// What a soak is to do.
struct SoakPlan {
  std::string session;
  std::uint64_t publications = 0;  // 0: until killed
  std::uint64_t kills = 0;
  std::uint64_t spacing_ns = 0;  // between publications; 0: at full speed
  std::size_t bytes = 0;         // of a snapshot, a multiple of 8
  std::size_t words_a_tick = 0;  // 0: all
  std::uint64_t seed = 0;
  bool skips_last_check = false;  // negative control: a reader without R5

  [[nodiscard]] std::size_t words() const noexcept { return bytes / 8; }
};

inline constexpr std::uint64_t kSoakTick_ns = 1'000'000;
inline constexpr std::uint64_t kSoakLayoutHash = 0x50A4;
inline constexpr std::uint64_t kMaxKills = 100'000;

/// What the reader counted. A tick counts once its segment holds a snapshot. A missed tick is a
/// wake that skipped deadlines, one or many, as in haptic_server's report.
struct ReaderTally {
  std::uint64_t ticks = 0, missed_ticks = 0, ticks_before_a_snapshot = 0;
  std::uint64_t accepted = 0, snapshots = 0;
  std::uint64_t torn = 0, mixed = 0, backwards = 0;
  std::uint64_t nothing_shown = 0;                 // both attempts failed, no earlier snapshot
  std::array<std::uint64_t, 3> failed_attempts{};  // ticks with 0, 1, 2 of them
  std::uint64_t inspected = 0, inspections_rejected = 0;
  std::uint64_t segments = 0, deaths_seen = 0, refusals = 0;
  std::uint64_t realtime_missing = 0;  // rights that it went without
  realtime::Histogram read_ns, wake_ns;
};

/// The first accepted read of a writer's snapshots.
struct FirstRead {
  std::uint32_t writer_pid = 0;
  std::uint64_t time_ns = 0;
};

/// What the processes of a soak tell each other beside the segment under test; in memory that all
/// of them map. Results are read once the process that writes them has ended.
struct SoakState {
  std::atomic<bool> reader_may_end = false;
  std::atomic<bool> writer_may_end = false;
  std::atomic<std::uint64_t> snapshot_id_read = 0;
  std::atomic<std::uint32_t> writer_read = 0;  // pid
  std::atomic<bool> writer_alive = false;      // as the reader last saw it
  ReaderTally reader;
  realtime::Histogram publish_ns;
  std::uint64_t first_read_count = 0;
  std::array<FirstRead, kMaxKills + 2> first_reads{};
};

/// A SoakState that child processes share.
class SharedSoakState {
 public:
  SharedSoakState();
  ~SharedSoakState();
  SharedSoakState(const SharedSoakState&) = delete;
  SharedSoakState& operator=(const SharedSoakState&) = delete;

  SoakState& operator*() const noexcept { return *state_; }
  SoakState* operator->() const noexcept { return state_; }

 private:
  SoakState* state_;
};

}  // namespace stillgrid::soak
