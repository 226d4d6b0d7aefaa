#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "proto/scene_segment.hpp"

namespace stillgrid {

/// How the displayed scene passes from one snapshot to the next: a row of transitions() each.
enum class Transition { kHold, kLinear, kRestart, kHermite, kExtrapolate, kPlayout, kAnswer };

/// How late `answer` shows what answers, period_s being that of its foresight: its drag damps a
/// heavy body in a hand that nothing else damps, which encoder steps would keep swinging
/// (docs/algorithms/stability.md).
[[nodiscard]] constexpr double drift_lag_s(double period_s) noexcept {
  return period_s < 0.01 ? 0.6 * period_s : proto::kForesightLag_s;
}

/// What is displayed of every sphere, told by the images of its history:
///   the sum of its positions by `position` (they sum to one), and of its velocities by
///   `velocity_s`, and drift_s times its drift. Its velocity is shown as the sum by `position`.
struct ImageWeights {
  std::array<double, proto::kHistoryLength> position{};        // newest first
  std::array<double, proto::kHistoryLength - 1> velocity_s{};  // likewise
  double drift_s = 0.0;       // for which the newest image's drift is followed
  double answer_lag_s = 0.0;  // less that, by spheres that answer
  double answer_share = 0.0;  // of its answer, a newton of which is shown a newton of change
  double alpha = 1.0;         // progress to the newest image, of 1
  bool stands = false;        // at the newest image, waiting for the next
};

/// What a transition keeps from one image to the next.
struct TransitionMemory {
  ImageWeights at_switch;         // displayed when the newest image came, told by its history
  ImageWeights rate_at_switch;    // and how it changed then, per second
  double latency_s = 0.0;         // of playout when the newest image came
  double latency_target_s = 0.0;  // towards which it moves
};

/// A transition's law, and what is said of it.
struct TransitionLaw {
  Transition transition;
  std::string_view name;    // as --transition takes it
  std::string_view remark;  // a phrase for --help
  bool gives_way = false;   // spheres yield to the hand between snapshots: a solver each tick
  ImageWeights (*weights)(const TransitionMemory& memory, const proto::SnapshotHeader& snapshot,
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
[[nodiscard]] ImageWeights image_weights(Transition transition, const TransitionMemory& memory,
                                         const proto::SnapshotHeader& snapshot,
                                         std::uint64_t now_ns) noexcept;

/// The memory with which `now` is displayed, when the image displayed until then was `before`, by
/// `memory`. Pure. Realtime: yes.
[[nodiscard]] TransitionMemory after_switch(Transition transition, const TransitionMemory& memory,
                                            const proto::SnapshotHeader& before,
                                            const proto::SnapshotHeader& now) noexcept;

/// Of the first image that is displayed.
[[nodiscard]] TransitionMemory at_first_image() noexcept;

/// Weights that were of an image, told by the history of the one that came `later` images after it.
/// Images that history no longer holds count as its oldest; drift and answer go with their image.
/// Realtime: yes.
[[nodiscard]] ImageWeights in_later_image(const ImageWeights& weights,
                                          std::uint64_t later) noexcept;

}  // namespace stillgrid
