#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "proto/scene_segment.hpp"

namespace stillgrid::display {

/// How the displayed scene passes from one snapshot to the next: a row of transitions() each.
enum class Transition {
  kHold,
  kLinear,
  kLocal  // of its snapshots as kLinear, where the simulation cannot go on here
};

struct TransitionLaw {
  Transition transition;
  std::string_view name;    // as --transition takes it
  std::string_view remark;  // a phrase for --help
};

/// Returns all of them, in the order of the enumeration.
[[nodiscard]] std::span<const TransitionLaw> transitions() noexcept;
[[nodiscard]] std::string_view name_of(Transition transition) noexcept;
[[nodiscard]] std::optional<Transition> transition_named(std::string_view name) noexcept;

/// What is displayed of a snapshot's history: the newest by alpha, the one before it by the rest
/// of 1. Velocities are weighed likewise. Below 0: before both, on a way that goes on evenly.
struct SnapshotWeights {
  double alpha = 1.0;
  bool is_waiting = true;  // at the newest snapshot, waiting for the next
};

/// Returns what is displayed at now_ns, on the clock of the snapshot's stamps, where T_n are those
/// of publication.
/// Realtime: yes; bounded whatever the stamps say. docs/algorithms/transitions.md.
[[nodiscard]] SnapshotWeights snapshot_weights(Transition transition,
                                               const proto::SnapshotHeader& snapshot,
                                               std::uint64_t now_ns) noexcept;

/// Returns weights that were of a snapshot, told by the history of the one that came `later`
/// snapshots after it, as if spheres went on evenly. Realtime: yes.
[[nodiscard]] inline SnapshotWeights in_later_snapshot(const SnapshotWeights& weights,
                                                       std::uint64_t later) noexcept {
  if (later == 0) return weights;
  return {.alpha = later == 1 ? weights.alpha - 1.0 : -1.0, .is_waiting = false};
}

}  // namespace stillgrid::display
