#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/publication/scene_segment.hpp"
#include "shared/reading/snapshot.hpp"
#include "shared/tools/scene_relay/messages.hpp"
#include "shared/tools/scene_relay/shown_tool.hpp"

namespace stillgrid::scene_relay {

/// What a simulation tells of one of its states: neither history nor grid, which the other side
/// makes of the snapshots that reach it.
struct ToldSnapshot {
  std::uint64_t snapshot_id = 0;
  std::uint64_t state_time_ns = 0, publish_time_ns = 0;  // the simulation's clock
  std::uint64_t tool_time_ns = 0;                        // the hand's, 0: none
  std::uint64_t step_ns = 0, contacts = 0;
  double tool_work_J = 0.0;
  std::vector<Motion> motions;      // by sphere
  std::vector<Label> labels;        // likewise
  std::vector<FieldMotion> fields;  // of the bodies with fields that move, in order
  std::uint64_t state_tick = 0;     // number on the hand's path
  std::uint64_t state_hash = 0;
  std::vector<std::uint8_t> state;  // empty: there is no state
};

/// Returns a snapshot that was read whole, without its state. tool_time_ns: its tool sample's, on
/// the hand's clock.
[[nodiscard]] ToldSnapshot told(const reading::SceneSnapshot& snapshot, std::uint64_t tool_time_ns);
/// The same with its state, by the path and the clock of the hand whose tool is shown here. Before
/// the tool's first sample the state is left out.
[[nodiscard]] ToldSnapshot with_state(const reading::SceneSnapshot& snapshot,
                                      const ShownTool& tool);

/// What a snapshot may be of, by the scene that it belongs to.
struct SnapshotLimits {
  std::uint32_t moving_capacity = 0;
  std::uint32_t material_count = 0;
  std::uint32_t moving_fields = 0;
  std::uint64_t state_capacity = 0;  // bytes
};

/// Throws MessageError unless every count, index and number is sound. The bytes of a state are
/// checked by who decodes them.
void check(const ToldSnapshot& snapshot, const SnapshotLimits& limits);

}  // namespace stillgrid::scene_relay
