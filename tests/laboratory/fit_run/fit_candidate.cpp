#include "tests/laboratory/fit_run/fit_candidate.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "shared/realtime/percentile.hpp"
#include "tests/laboratory/metrics.hpp"

namespace stillgrid::fit_run {
namespace {

using realtime::percentile;

std::string text_of(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

laboratory::LabOptions options_of(const FitCandidate& candidate, const FitPath& path,
                                  const FitReference& reference, double latency_share) {
  laboratory::LabOptions options = path_options(path);
  options.duration_s =
      std::min(options.duration_s, static_cast<double>(reference.rows.size()) / 1e3);
  options.transition = candidate.transition;
  options.latency_s = latency_share * candidate.scene.period_s;
  options.start = &reference.start;
  options.measures_ticks = true;
  return options;
}

void require_same_path(const laboratory::LabRun& run, const FitReference& reference) {
  for (std::size_t i = 0; i < std::min(run.rows.size(), reference.rows.size()); ++i)
    if (run.rows[i].position_m != reference.rows[i].position_m)
      throw std::runtime_error(
          "--reference: at " + text_of(run.rows[i].time_s) +
          " s the tool is elsewhere: expected a reference of this trajectory with these --replay "
          "options and the scene's [device]");
}

bool same_forces(const laboratory::LabRun& a, const laboratory::LabRun& b) {
  return std::equal(a.rows.begin(), a.rows.end(), b.rows.begin(), b.rows.end(),
                    [](const recording::TickRow& x, const recording::TickRow& y) {
                      return x.rendered_N == y.rendered_N;
                    });
}

/// Of each figure the median.
FitCost median_of(const std::vector<FitCost>& costs) {
  FitCost median;
  for (double FitCost::*figure :
       {&FitCost::processor_us_per_ms, &FitCost::simulation_us_per_ms, &FitCost::tick_p50_us,
        &FitCost::tick_p99_us, &FitCost::step_p50_ms, &FitCost::step_p95_ms,
        &FitCost::step_share}) {
    std::vector<double> values;
    for (const FitCost& cost : costs) values.push_back(cost.*figure);
    median.*figure = percentile(std::move(values), 0.5);
  }
  return median;
}

void judge(const laboratory::LabRun& run, const FitReference& reference, FitResult& result) {
  require_same_path(run, reference);
  result.simulation = run.simulation;
  const auto is_bad = [](const recording::TickRow& row) { return !row.rendered_N.allFinite(); };
  if (run.device_failed || std::any_of(run.rows.begin(), run.rows.end(), is_bad))
    result.problems.emplace_back("a force was no number");
  const double rate_hz = run.report.rate_hz;
  result.error = fit_error(run.rows, reference.rows, rate_hz);
  result.switch_jump_jnd_max = laboratory::switch_metrics(run).jump_jnd.max;
  result.stage_felt_share =
      laboratory::stages(laboratory::rendered_N(run.rows), rate_hz).felt_share;
}

}  // namespace

FitCost cost_of(const laboratory::LabRun& run, double period_s) {
  const double ticks = static_cast<double>(std::max<std::size_t>(run.rows.size(), 1));
  double simulation_s = 0.0;
  for (const double step_s : run.simulation.step_s) simulation_s += step_s;
  std::vector<double> touching_us, all_us;
  for (const recording::TickRow& row : run.rows) {
    const double tick_us = 1e-3 * static_cast<double>(row.tick_ns);
    all_us.push_back(tick_us);
    if (row.contacts > 0) touching_us.push_back(tick_us);
  }
  const std::vector<double>& ticks_us = touching_us.empty() ? all_us : touching_us;
  const double per_ms = 1e6 / (ticks * 1e3 / run.report.rate_hz);
  const double slow_s = percentile(run.simulation.step_s, 0.95);
  return {.processor_us_per_ms = run.processor_s * per_ms,
          .simulation_us_per_ms = simulation_s * per_ms,
          .tick_p50_us = percentile(ticks_us, 0.5),
          .tick_p99_us = percentile(ticks_us, 0.99),
          .step_p50_ms = 1e3 * percentile(run.simulation.step_s, 0.5),
          .step_p95_ms = 1e3 * slow_s,
          .step_share = slow_s / period_s};
}

double latency_share_of(double step_share) {
  return step_share < 0.05 ? 0.0 : std::ceil(10.0 * step_share) / 10.0;
}

FitResult run_candidate(const FitCandidate& candidate, const FitPath& path,
                        const FitReference& reference) {
  FitResult result;
  std::vector<FitCost> costs;
  const auto run_at = [&](double latency_share) {
    laboratory::LabRun run =
        laboratory::run_lab(candidate.scene, options_of(candidate, path, reference, latency_share));
    costs.push_back(cost_of(run, candidate.scene.period_s));
    return run;
  };
  const auto too_slow = [&](double share) {
    result.problems.push_back("cannot keep its rate: 5 % of the steps take more than " +
                              text_of(share) + " of the period");
  };
  try {
    laboratory::LabRun run = run_at(candidate.latency_share.value_or(0.0));
    result.latency_share = candidate.latency_share.value_or(0.0);
    const double asked = candidate.latency_share.value_or(latency_share_of(costs[0].step_share));
    if (costs[0].step_share > 1.0) {
      too_slow(costs[0].step_share);
    } else if (asked != result.latency_share) {
      costs.clear();
      result.latency_share = asked;
      run = run_at(asked);
    }
    while (result.problems.empty() && std::ssize(costs) < candidate.repeats)
      if (!same_forces(run, run_at(result.latency_share)))
        throw std::logic_error("two runs of one candidate have other forces");
    judge(run, reference, result);
    result.cost = median_of(costs);
  } catch (const std::domain_error& error) {  // a place that is no number
    result.problems.push_back(std::string("the simulation ended: ") + error.what());
  }
  return result;
}

}  // namespace stillgrid::fit_run
