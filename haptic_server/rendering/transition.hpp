#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "proto/scene_segment.hpp"

namespace stillgrid {

/// How the displayed scene passes from one still image to the next. P: the period, v: a body's
/// speed; lags are behind the scene of the present, for images that are published at once.
enum class Transition {
  kHold,         // the latest image as it is: jumps by v P
  kLinear,       // the paper's: from the image before to the latest over one period; lags by v P
  kRestart,      // from what is displayed to the latest over one period: never jumps, lags by v P
  kHermite,      // as restart, with the velocities too: no kink, overshoots where a body stops
  kExtrapolate,  // the latest image, moved on by its velocities: no lag, jumps by a P^2 / 2
  kPlayout,      // the past, as late as images come: no jump, no stage, lags by P and more
  kAnswer,  // the simulation's own next step, for the hand as it is now: no jump, lag 0 to 6 ms
};

/// Names as --transition takes them, in the order of the enumeration.
inline constexpr std::array<std::string_view, 7> kTransitionNames = {
    "hold", "linear", "restart", "hermite", "extrapolate", "playout", "answer"};

[[nodiscard]] std::optional<Transition> transition_named(std::string_view name);
[[nodiscard]] std::string_view name_of(Transition transition);

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

/// What is displayed at now_ns, on the clock of the snapshot's stamps, T_n being those of
/// publication.
///
/// Linear: a(t) = min((t - Tn) / (Tn - Tn-1), 1), the next switch being expected after a period
/// like the last [Davanne 2002, section 4; the print's max is a slip, its text fits only min].
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
