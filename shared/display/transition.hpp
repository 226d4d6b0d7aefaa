#pragma once

#include <array>
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
  kRestart,
  kHermite,
  kExtrapolate,
  kPlayout,
  kPredict,
  kLocal
};

/// How late `predict` shows what is compliant, period_s being that of its prediction and body_kg
/// the inertia by which it resists: the lag's drag damps a body that moves with the hand, which
/// encoder steps would keep swinging, the more the more of the mass is the body's
/// (docs/algorithms/stability.md). Realtime: yes.
[[nodiscard]] double prediction_lag_s(double period_s, double body_kg) noexcept;

/// The least inertia with which a snapshot's spheres resist the tool, kg; 0 where none responds, or
/// the snapshot lies. What springs hold counts as less. Realtime: yes.
[[nodiscard]] double responding_kg(const proto::SnapshotHeader& snapshot) noexcept;

/// Weights by which every sphere is displayed from the snapshots of its history:
///   the sum of its positions by `position` (they sum to one), and of its velocities by
///   `velocity_s`, and prediction_s times its predicted velocity. Its velocity is shown as the sum
///   by `position`.
struct SnapshotWeights {
  std::array<double, proto::kHistoryLength> position{};        // newest first
  std::array<double, proto::kHistoryLength - 1> velocity_s{};  // likewise
  double prediction_s = 0.0;      // for which the newest snapshot's predicted velocity is followed
  double compliance_lag_s = 0.0;  // less that, by spheres that give way
  double step_share = 0.0;        // of the predicted step, by which they do
  double pace = 1.0;              // by which that grows, of real time: 0 where a snapshot stands
  double alpha = 1.0;             // progress to the newest snapshot, of 1
  bool is_waiting = false;        // at the newest snapshot, waiting for the next
};

/// The memory of a transition from one snapshot to the next.
struct TransitionMemory {
  SnapshotWeights at_switch;       // displayed when the newest snapshot came, told by its history
  SnapshotWeights rate_at_switch;  // and how it changed then, per second
  double latency_s = 0.0;          // of playout when the newest snapshot came
  double latency_target_s = 0.0;   // towards which it moves
};

/// A transition's law, and what is said of it.
struct TransitionLaw {
  Transition transition;
  std::string_view name;    // as --transition takes it
  std::string_view remark;  // a phrase for --help
  bool gives_way = false;   // spheres give way to the hand between snapshots: a solver each tick
  SnapshotWeights (*weights)(const TransitionMemory& memory, const proto::SnapshotHeader& snapshot,
                             std::uint64_t now_ns) noexcept;
};

/// All laws, in the order of the enumeration.
[[nodiscard]] std::span<const TransitionLaw> transitions() noexcept;

[[nodiscard]] const TransitionLaw& law_of(Transition transition) noexcept;
[[nodiscard]] std::string_view name_of(Transition transition) noexcept;
[[nodiscard]] std::optional<Transition> transition_named(std::string_view name) noexcept;

/// What is displayed at now_ns, on the clock of the snapshot's stamps, T_n being those of
/// publication.
/// Pure. Realtime: yes; bounded whatever the stamps say. docs/algorithms/transitions.md.
[[nodiscard]] SnapshotWeights snapshot_weights(Transition transition,
                                               const TransitionMemory& memory,
                                               const proto::SnapshotHeader& snapshot,
                                               std::uint64_t now_ns) noexcept;

/// The memory with which `now` is displayed, when the snapshot displayed until then was `before`,
/// by `memory`. Pure. Realtime: yes.
[[nodiscard]] TransitionMemory after_switch(Transition transition, const TransitionMemory& memory,
                                            const proto::SnapshotHeader& before,
                                            const proto::SnapshotHeader& now) noexcept;

/// Of the first snapshot that is displayed.
[[nodiscard]] TransitionMemory at_first_snapshot() noexcept;

/// Weights that were of a snapshot, told by the history of the one that came `later` snapshots
/// after it. Snapshots that history no longer holds count as its oldest; predicted velocity and
/// compliance go with their snapshot. Realtime: yes.
[[nodiscard]] SnapshotWeights in_later_snapshot(const SnapshotWeights& weights,
                                                std::uint64_t later) noexcept;

}  // namespace stillgrid::display
