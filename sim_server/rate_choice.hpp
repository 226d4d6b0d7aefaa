#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/felt_force.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// What became of one rate in the choice.
struct RateTrial {
  double rate_hz = 0.0;
  std::optional<double> processor_share = {};  // of the simulation; the most of its runs
  std::optional<double> error_share = {};      // of the true force, rms; the worst of its runs
  int runs = 0;              // each with the steps elsewhere in time, an eighth of a period apart
  std::string refusal = {};  // why it was not chosen; empty: chosen
};

/// The rate chosen for a scene, and what was seen on the way.
struct RateChoice {
  double rate_hz = 0.0;
  std::vector<RateTrial> trials;  // the highest rate first
  double watched_s = 0.0;         // of the hand's path, beside a reference
  bool keeps_force = false;       // it errs by no more than a just noticeable difference
  bool keeps_share = false;       // it costs no more than scene.processor_share
};

/// How long a choice may take on its clock, but for the run that is under way then.
inline constexpr double kServerBudget_s = 10.0, kExplainBudget_s = 60.0;

/// Chooses the lowest rate at which the force on the scene's own hand errs by no more than a just
/// noticeable difference (rendering::kJustNoticeable), at it and at every higher rate that the
/// share of a processor allows; where none does, the most accurate that it allows.
///
/// The scene comes to rest for hand->settle_s; then the hand is led through it at each of eleven
/// rates from 10 Hz to 1 kHz, and at the scene's own if it has one, in virtual time, shown as
/// haptic_server shows it by default and as late as steps are slow, and its force is held against
/// the truth: implicit Euler at 1 kHz, each snapshot shown at once. A rate is run again with its
/// steps elsewhere in time, eight times in all or as often as the budget allows; the worst counts.
/// Where the budget ends the reference, what it came to is watched; where it touched nothing by
/// then no error is known, and the highest rate within the share is taken.
///
/// start: build_world(scene). now_s: a clock; it decides, so that two choices may differ: record
/// one for virtual time (sim_server/rate_record.hpp). tell: called with a line of progress.
/// Throws std::runtime_error for a hand that cannot be read, SegmentError. Pre: scene.hand.
[[nodiscard]] RateChoice choose_rate(const scene::SceneDescription& scene,
                                     const bodies::World& start, double budget_s,
                                     const CostClock& now_s,
                                     const std::function<void(const std::string&)>& tell);

}  // namespace stillgrid::sim_server
