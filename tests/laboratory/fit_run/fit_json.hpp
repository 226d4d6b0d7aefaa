#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/laboratory/fit_run/fit_candidate.hpp"
#include "tests/laboratory/fit_run/fit_stability.hpp"

namespace stillgrid::fit_run {

/// What decided a run, for its JSON: enough to repeat it.
struct FitSettings {
  std::vector<std::string> set;
  std::string scene, trajectory, replay, transition, method;
  double rate_hz = 0.0;
  std::optional<double> latency_share;
  double settle_s = 0.0;
};

/// What was asked of stability, and what came of it.
struct FitStabilityResult {
  std::string profile;
  double margin = 1.0;
  FitStability found;
  bool searched = false;
  std::optional<double> largest_margin;  // if searched
};

/// The result of a candidate as one line, without its end; docs/formats.md, "fit_run". What is no
/// number, or is not there, is null.
[[nodiscard]] std::string json_line(const FitSettings& settings, const FitReference& reference,
                                    const FitResult& result, int repeats,
                                    const std::optional<FitStabilityResult>& stability);

/// The same of a reference that was written.
[[nodiscard]] std::string json_line(const FitSettings& settings, const FitReference& reference,
                                    const laboratory::LabRun& run, double period_s);

}  // namespace stillgrid::fit_run
