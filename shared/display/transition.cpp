#include "shared/display/transition.hpp"

#include <array>
#include <cstddef>

#include "shared/display/stamps.hpp"

namespace stillgrid::display {
namespace {

constexpr std::array kTransitions = {
    TransitionLaw{Transition::kHold, "hold", "the latest snapshot as it is"},
    TransitionLaw{Transition::kLinear, "linear", "the paper's, evenly from the snapshot before"},
    TransitionLaw{Transition::kLocal, "local",
                  "the simulation itself, goes on here from its snapshots"},
};

/// Progress over a period like the last, from the newest switch.
double progress(const proto::SnapshotHeader& snapshot, std::uint64_t now_ns) noexcept {
  if (snapshot.history_count < 2) return 1.0;
  const double period_s = seconds_between(snapshot.publish_time_ns[1], snapshot.publish_time_ns[0]);
  const double since_s = seconds_between(snapshot.publish_time_ns[0], now_ns);
  return since_s < period_s ? since_s / period_s : 1.0;
}

}  // namespace

std::span<const TransitionLaw> transitions() noexcept {
  return kTransitions;
}

std::string_view name_of(Transition transition) noexcept {
  return kTransitions[static_cast<std::size_t>(transition)].name;
}

std::optional<Transition> transition_named(std::string_view name) noexcept {
  for (const TransitionLaw& law : kTransitions)
    if (law.name == name) return law.transition;
  return std::nullopt;
}

/// a(t) = min((t - Tn) / (Tn - Tn-1), 1): the next switch is expected after a period like the last.
/// A body of speed v lags by v times the period [Davanne 2002, section 4; the print's max is a
/// slip, its text fits only min]. `hold` jumps by that.
SnapshotWeights snapshot_weights(Transition transition, const proto::SnapshotHeader& snapshot,
                                 std::uint64_t now_ns) noexcept {
  const double alpha = transition == Transition::kHold ? 1.0 : progress(snapshot, now_ns);
  return {.alpha = alpha, .is_waiting = alpha == 1.0};
}

}  // namespace stillgrid::display
