#include "shared/display/transition.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "shared/collision/sphere_history.hpp"
#include "shared/display/stamps.hpp"

namespace stillgrid::display {
namespace {

using proto::SnapshotHeader;

/// How fast the latency of playout changes, of real time: slower or faster bodies are not felt.
constexpr double kLatencySlew = 0.1;
/// Share of the way to a smaller latency that it goes a snapshot.
constexpr double kLatencyDecay = 1.0 / 64.0;

SnapshotWeights newest_snapshot() noexcept {
  SnapshotWeights weights;
  weights.position[0] = 1.0;
  weights.is_waiting = true;
  return weights;
}

/// Between the last two switches; zero without two.
double last_period_s(const SnapshotHeader& snapshot) noexcept {
  return snapshot.history_count > 1
             ? seconds_between(snapshot.publish_time_ns[1], snapshot.publish_time_ns[0])
             : 0.0;
}

/// Progress over a period like the last, from the newest switch.
double progress(const SnapshotHeader& snapshot, std::uint64_t now_ns) noexcept {
  const double period_s = last_period_s(snapshot);
  const double since_s = seconds_between(snapshot.publish_time_ns[0], now_ns);
  return since_s < period_s ? since_s / period_s : 1.0;
}

void add(SnapshotWeights& sum, const SnapshotWeights& weights, double factor) noexcept {
  for (std::size_t i = 0; i < sum.position.size(); ++i)
    sum.position[i] += factor * weights.position[i];
  for (std::size_t i = 0; i < sum.velocity_s.size(); ++i)
    sum.velocity_s[i] += factor * weights.velocity_s[i];
}

// The laws. P: the period, v: a body's speed; lags are behind the scene of the present, for
// snapshots that are published at once.

/// The latest snapshot as it is: jumps by v P.
SnapshotWeights hold(const TransitionMemory&, const SnapshotHeader&, std::uint64_t) noexcept {
  return newest_snapshot();
}

/// From the snapshot before to the latest: a(t) = min((t - Tn) / (Tn - Tn-1), 1), the next switch
/// being expected after a period like the last; lags by v P [Davanne 2002, section 4; the print's
/// max is a slip, its text fits only min].
SnapshotWeights linear(const TransitionMemory&, const SnapshotHeader& snapshot,
                       std::uint64_t now_ns) noexcept {
  SnapshotWeights weights;
  weights.alpha = progress(snapshot, now_ns);
  weights.position[0] = weights.alpha;
  weights.position[1] = 1.0 - weights.alpha;
  weights.is_waiting = weights.alpha == 1.0;
  return weights;
}

/// From what is displayed to the latest over one period: never jumps, lags by v P.
SnapshotWeights restart(const TransitionMemory& memory, const SnapshotHeader& snapshot,
                        std::uint64_t now_ns) noexcept {
  SnapshotWeights weights;
  weights.alpha = progress(snapshot, now_ns);
  weights.position[0] = weights.alpha;
  add(weights, memory.at_switch, 1.0 - weights.alpha);
  weights.is_waiting = weights.alpha == 1.0;
  return weights;
}

/// As restart, with the velocities too: no kink, overshoots where a body stops.
SnapshotWeights hermite(const TransitionMemory& memory, const SnapshotHeader& snapshot,
                        std::uint64_t now_ns) noexcept {
  const double s = progress(snapshot, now_ns), period_s = last_period_s(snapshot);
  SnapshotWeights weights;
  weights.alpha = s;
  weights.position[0] = s * s * (3.0 - 2.0 * s);
  weights.velocity_s[0] = period_s * s * s * (s - 1.0);
  add(weights, memory.at_switch, 1.0 - s * s * (3.0 - 2.0 * s));
  add(weights, memory.rate_at_switch, period_s * s * (s - 1.0) * (s - 1.0));
  weights.is_waiting = s == 1.0;
  return weights;
}

/// The latest snapshot, moved on by its velocities: no lag, jumps by a P^2 / 2.
SnapshotWeights extrapolate(const TransitionMemory&, const SnapshotHeader& snapshot,
                            std::uint64_t now_ns) noexcept {
  SnapshotWeights weights;
  weights.position[0] = 1.0;
  const double period_s = snapshot.history_count > 1 ? seconds_between(snapshot.state_time_ns[1],
                                                                       snapshot.state_time_ns[0])
                                                     : 0.0;
  const double age_s = seconds_between(snapshot.state_time_ns[0], now_ns);
  weights.velocity_s[0] = std::min(age_s, proto::kPredictionPeriods * period_s);
  weights.is_waiting = !(age_s < proto::kPredictionPeriods * period_s);
  return weights;
}

double latency_s(const TransitionMemory& memory, const SnapshotHeader& snapshot,
                 std::uint64_t now_ns) noexcept {
  const double most_s = kLatencySlew * seconds_between(snapshot.publish_time_ns[0], now_ns);
  return memory.latency_s + std::clamp(memory.latency_target_s - memory.latency_s, -most_s, most_s);
}

/// The past, as late as snapshots come, linear between the two round the time shown: no jump, no
/// stage, lags by P and more.
SnapshotWeights playout(const TransitionMemory& memory, const SnapshotHeader& snapshot,
                        std::uint64_t now_ns) noexcept {
  const auto& state_ns = snapshot.state_time_ns;
  const double late_s = latency_s(memory, snapshot, now_ns);
  // Times are counted back from the newest snapshot: how long before it is what is shown?
  const double back_s = late_s - seconds_between(state_ns[0], now_ns);
  SnapshotWeights weights;
  weights.alpha = 0.0;
  double newer_s = 0.0;
  for (std::size_t i = 0; i + 1 < proto::kHistoryLength; ++i) {
    const double older_s = seconds_between(state_ns[i + 1], state_ns[0]);
    if (back_s < older_s) {
      const double share = std::max(0.0, (back_s - newer_s) / (older_s - newer_s));
      weights.position[i] = 1.0 - share;
      weights.position[i + 1] = share;
      if (i == 0) weights.alpha = 1.0 - share;
      weights.is_waiting = back_s < 0.0;
      return weights;
    }
    newer_s = older_s;
  }
  weights.position.back() = 1.0;
  return weights;
}

/// How late what is compliant is shown: of a period, at least, and beside which inertia of hand and
/// device (docs/cases.md, case 1.14) that of a body counts.
constexpr double kLagPeriods = 0.6;
constexpr double kShortestLag_s = 6e-3;
constexpr double kHand_kg = 0.654;

/// What is led on for two periods stands then, and stops evenly over one, half of it beyond them.
constexpr double kStop = 0.5;

double coming_to_rest(double periods) {
  const double left = proto::kPredictionPeriods + kStop - periods;
  if (left >= 2.0 * kStop) return periods;
  return left > 0.0 ? proto::kPredictionPeriods - left * left / (4.0 * kStop)
                    : proto::kPredictionPeriods;
}

/// How fast that goes on.
double pace(double periods) {
  return std::clamp((proto::kPredictionPeriods + kStop - periods) / (2.0 * kStop), 0.0, 1.0);
}

/// The latest snapshot led on by the simulation's own next step: no jump, lags by 0 to 13 ms.
SnapshotWeights predict(const TransitionMemory&, const SnapshotHeader& snapshot,
                        std::uint64_t now_ns) noexcept {
  SnapshotWeights weights = newest_snapshot();
  const double period_s = static_cast<double>(snapshot.prediction_ns) * 1e-9;
  if (!(period_s > 0.0)) return weights;
  const double age = seconds_between(snapshot.state_time_ns[0], now_ns) / period_s;
  weights.is_waiting = !(age < proto::kPredictionPeriods + kStop);
  weights.step_share = coming_to_rest(age);
  weights.pace = pace(age);
  weights.prediction_s = weights.step_share * period_s;
  weights.compliance_lag_s = prediction_lag_s(period_s, responding_kg(snapshot));
  return weights;
}

/// The latency that would have let the snapshot before last until this one came.
double needed_latency_s(const SnapshotHeader& snapshot) noexcept {
  return snapshot.history_count > 1
             ? seconds_between(snapshot.state_time_ns[1], snapshot.publish_time_ns[0])
             : 0.0;
}

constexpr std::array kTransitions = {
    TransitionLaw{Transition::kHold, "hold", "the latest snapshot as it is", false, hold},
    TransitionLaw{Transition::kLinear, "linear", "the paper's", false, linear},
    TransitionLaw{Transition::kRestart, "restart", "never jumps", false, restart},
    TransitionLaw{Transition::kHermite, "hermite", "no kink", false, hermite},
    TransitionLaw{Transition::kExtrapolate, "extrapolate", "by velocities", false, extrapolate},
    TransitionLaw{Transition::kPlayout, "playout", "as late as snapshots come", false, playout},
    TransitionLaw{Transition::kPredict, "predict",
                  "the simulation's own next step, for the hand where it is", true, predict},
    TransitionLaw{Transition::kLocal, "local",
                  "the simulation itself, goes on here from its snapshots", false, hold},
};

}  // namespace

double prediction_lag_s(double period_s, double body_kg) noexcept {
  const double longest_s = std::min(kLagPeriods * period_s, proto::kLongestPredictionLag_s);
  const double shortest_s = std::min(longest_s, kShortestLag_s);
  return shortest_s + (longest_s - shortest_s) * body_kg / (body_kg + kHand_kg);
}

double responding_kg(const proto::SnapshotHeader& snapshot) noexcept {
  const double period_s = static_cast<double>(snapshot.prediction_ns) * 1e-9;
  double inertia_share = 1.0;
  for (std::size_t i = 0; i < std::min<std::size_t>(snapshot.mode_count, proto::kMaxModes); ++i)
    inertia_share = std::min(inertia_share, static_cast<double>(snapshot.modes[i].inertia_share));
  // A free mass gives way by period_s^2 / mass along each of three directions.
  const double per_kg = snapshot.largest_response * snapshot.largest_response / 3.0;
  const double body_kg = inertia_share * period_s * period_s / per_kg;
  return body_kg >= 0.0 && body_kg <= proto::kLargestNumber ? body_kg : 0.0;
}

std::span<const TransitionLaw> transitions() noexcept {
  return kTransitions;
}

const TransitionLaw& law_of(Transition transition) noexcept {
  return kTransitions[static_cast<std::size_t>(transition)];
}

std::string_view name_of(Transition transition) noexcept {
  return law_of(transition).name;
}

std::optional<Transition> transition_named(std::string_view name) noexcept {
  for (const TransitionLaw& law : kTransitions)
    if (law.name == name) return law.transition;
  return std::nullopt;
}

SnapshotWeights snapshot_weights(Transition transition, const TransitionMemory& memory,
                                 const SnapshotHeader& snapshot, std::uint64_t now_ns) noexcept {
  return law_of(transition).weights(memory, snapshot, now_ns);
}

TransitionMemory at_first_snapshot() noexcept {
  TransitionMemory memory;
  memory.at_switch = newest_snapshot();
  return memory;
}

TransitionMemory after_switch(Transition transition, const TransitionMemory& memory,
                              const SnapshotHeader& before, const SnapshotHeader& now) noexcept {
  constexpr std::uint64_t kMoment_ns = 1000;
  const std::uint64_t switch_ns = now.publish_time_ns[0];
  const std::uint64_t later = now.snapshot_id - before.snapshot_id;
  const auto displayed = [&](std::uint64_t time_ns) {
    return in_later_snapshot(snapshot_weights(transition, memory, before, time_ns), later);
  };
  TransitionMemory next;
  next.at_switch = displayed(switch_ns);
  if (switch_ns >= kMoment_ns) {
    constexpr double kPerSecond = 1e9 / static_cast<double>(kMoment_ns);
    add(next.rate_at_switch, next.at_switch, kPerSecond);
    add(next.rate_at_switch, displayed(switch_ns - kMoment_ns), -kPerSecond);
  }
  const double needed_s = needed_latency_s(now);
  // A snapshot later than the latency was waited for: the time shown goes on from where it stood.
  next.latency_s = std::max(needed_s, latency_s(memory, before, switch_ns));
  next.latency_target_s = std::max(
      needed_s, memory.latency_target_s + kLatencyDecay * (needed_s - memory.latency_target_s));
  return next;
}

SnapshotWeights in_later_snapshot(const SnapshotWeights& weights, std::uint64_t later) noexcept {
  if (later == 0) return weights;
  SnapshotWeights shifted;
  shifted.alpha = weights.alpha;
  shifted.is_waiting = weights.is_waiting;
  shifted.position = collision::in_later_history(weights.position, later);
  shifted.velocity_s = collision::in_later_history(weights.velocity_s, later);
  // The later snapshot tells no earlier predicted velocity; that snapshot's velocity is nearest to
  // it.
  shifted.velocity_s[std::min<std::uint64_t>(later, shifted.velocity_s.size() - 1)] +=
      weights.prediction_s;
  return shifted;
}

}  // namespace stillgrid::display
