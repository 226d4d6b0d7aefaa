#pragma once

#include <array>
#include <cstdint>

#include "tests/soak/soak_state.hpp"

namespace stillgrid::soak {

/// How far a writer had come when it was killed.
enum class Death { kBeforeItsObject, kHalfMade, kBeforeAnSnapshot, kInMidWrite, kBetweenSnapshots };
inline constexpr std::array<const char*, 5> kDeathNames{
    "before_its_object", "half_made", "before_a_snapshot", "in_mid_write", "between_snapshots"};

/// What became of the killed writers.
struct KillTally {
  std::array<std::uint64_t, kDeathNames.size()> deaths{};
  std::uint64_t locks_left = 0;      // objects that still counted as a living writer's
  std::uint64_t snapshots_lost = 0;  // dead objects whose last snapshot was not whole at once
  std::uint64_t leftovers = 0;       // files in shared memory at the very end
  std::uint64_t read_sum_ns = 0;
  realtime::Histogram
      read_ns;  // from a kill to the first accepted read of a later writer; not the last's
  bool last_death_seen = false;
  bool last_writer_read = false;  // that was not killed
};

/// A writer process and a reader process until the last snapshot was read. False when a process
/// failed or it took longer than it may, or the user stopped it.
bool run_publications(const SoakPlan& plan, SoakState& state);

/// Writer processes that are killed and replaced at once beside a reader process, then one that
/// ends in order. False as above.
bool run_kills(const SoakPlan& plan, SoakState& state, KillTally& kills);

}  // namespace stillgrid::soak
