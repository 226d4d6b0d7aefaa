#pragma once

#include <optional>
#include <string>
#include <vector>

#include "shared/rendering/renderer.hpp"
#include "sim_server/scene/scene_description.hpp"
#include "tests/laboratory/fit_run/fit_error.hpp"
#include "tests/laboratory/fit_run/fit_reference.hpp"
#include "tests/laboratory/lab.hpp"

namespace stillgrid::fit_run {

/// One way to simulate and to show a scene.
struct FitCandidate {
  scene::SceneDescription scene;
  display::Transition transition = display::Transition::kPredict;
  std::optional<double> latency_share = {};  // what a step costs, of its period; none: as measured
  int repeats = 1;                           // of the run whose cost counts
};

/// By the thread's processor clock, but ticks by the wall's; medians of the repeats.
struct FitCost {
  double processor_us_per_ms = 0.0;  // of both sides
  double simulation_us_per_ms = 0.0;
  double tick_p50_us = 0.0, tick_p99_us = 0.0;  // in contact, if there is any
  double step_p50_ms = 0.0, step_p95_ms = 0.0;  // with its snapshot
  double step_share = 0.0;                      // of the period: the slow step's, p95
};

/// What came of a candidate. Bad ones have problems, and the figures that there are.
struct FitResult {
  double latency_share = 0.0;  // of the run
  FitError error;
  std::optional<double> switch_jump_jnd_max, stage_felt_share;
  std::optional<FitCost> cost;
  laboratory::LabSimulation simulation;
  std::vector<std::string> problems;
};

[[nodiscard]] FitCost cost_of(const laboratory::LabRun& run, double period_s);

/// The share of a period, in tenths rounded up, that a step of that share is imitated by; none
/// under 0.05.
[[nodiscard]] double latency_share_of(double step_share);

/// Runs the candidate along the path from where the reference began. With no latency given a first
/// run, shown at once, measures the step; beyond 1.0 no other follows.
///
/// Throws std::runtime_error where the device was elsewhere than in the reference, DeviceError,
/// SegmentError.
[[nodiscard]] FitResult run_candidate(const FitCandidate& candidate, const FitPath& path,
                                      const FitReference& reference);

}  // namespace stillgrid::fit_run
