#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "shared/display/transition.hpp"

/// How a body is displayed between its snapshots, tick by tick, at regular periods.
namespace stillgrid::laboratory::two_rate {

/// The haptic period T; all times of the analysis are whole ticks of it.
inline constexpr double kTick_s = 1e-3;

/// What each tick of a period displays, from the first that shows a snapshot to the last before the
/// next one comes.
using Cycle = std::vector<display::SnapshotWeights>;

/// That of the product's transition, its memory settled, for snapshots of the state at their
/// sample's time that come `latency_ticks` after it.
[[nodiscard]] Cycle cycle_of(display::Transition transition, int period_ticks, int latency_ticks);

/// A law to try: what is displayed `ticks` after the newest snapshot came, where one comes every
/// `period_ticks`; at ticks == period_ticks, what the next snapshot finds displayed. at_switch:
/// what was displayed when the newest came, told by its history.
using Law = std::function<display::SnapshotWeights(int ticks, int period_ticks,
                                                   const display::SnapshotWeights& at_switch)>;
[[nodiscard]] Cycle cycle_of(const Law& law, int period_ticks);

/// The newest snapshot, whose body gives way to all of the tool's change of force since its sample:
/// of rivals/constraint_model.hpp, exactly, while contact lasts.
[[nodiscard]] Cycle constraints_cycle(int period_ticks);

/// From what was displayed to the newest snapshot in `share` of the period, but in no more than
/// `most_ticks`, then held. The tick that shows a new snapshot first goes its part of the way.
[[nodiscard]] Law ramp(double share, double most_ticks = INFINITY);

}  // namespace stillgrid::laboratory::two_rate
