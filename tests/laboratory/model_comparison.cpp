#include "tests/laboratory/model_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "sim_server/judge.hpp"

namespace stillgrid::laboratory {
namespace {

double tick_median_s(std::span<const recording::TickRow> rows) {
  std::vector<std::uint64_t> times_ns;
  for (const recording::TickRow& row : rows)
    if (row.contacts > 0) times_ns.push_back(row.tick_ns);
  if (times_ns.empty()) return 0.0;
  const auto middle = times_ns.begin() + std::ssize(times_ns) / 2;
  std::nth_element(times_ns.begin(), middle, times_ns.end());
  return 1e-9 * static_cast<double>(*middle);
}

double longest_period_s(std::span<const recording::TickRow> rows) {
  double longest_s = 0.0, since_s = -1.0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].snapshot_id == rows[i - 1].snapshot_id) continue;
    if (since_s >= 0.0) longest_s = std::max(longest_s, rows[i].time_s - since_s);
    since_s = rows[i].time_s;
  }
  return longest_s;
}

double rms_N(std::span<const recording::TickRow> rows) {
  double sum_N2 = 0.0;
  for (const recording::TickRow& row : rows) sum_N2 += row.rendered_N.squaredNorm();
  return rows.empty() ? 0.0 : std::sqrt(sum_N2 / static_cast<double>(rows.size()));
}

}  // namespace

std::vector<Contender> contenders() {
  std::vector<Contender> all;
  for (const display::TransitionLaw& law : display::transitions())
    all.push_back({std::string(law.name), nullptr, law.transition});
  for (const Rival& rival : rivals()) all.push_back({std::string(rival.name), &rival});
  for (const int rate_hz : {250, 500, 1000})
    all.push_back({"hold at " + std::to_string(rate_hz) + " Hz", nullptr,
                   display::Transition::kHold, 1.0 / rate_hz});
  return all;
}

LabRun from_time(const LabRun& run, double from_s) {
  const auto first =
      std::find_if(run.rows.begin(), run.rows.end(),
                   [&](const recording::TickRow& row) { return row.time_s >= from_s; });
  const auto left_out = static_cast<std::size_t>(first - run.rows.begin());
  LabRun rest;
  rest.report = run.report;
  rest.rows.assign(first, run.rows.end());
  for (const SwitchJump& jump : run.jumps)
    if (jump.tick >= left_out) rest.jumps.push_back({jump.tick - left_out, jump.jump_N});
  rest.report.energy = {};
  for (std::size_t i = 1; i < rest.rows.size(); ++i)
    safety::observe(rest.report.energy, {.force_N = rest.rows[i - 1].force_N},
                    {.moved_m = rest.rows[i].position_m - rest.rows[i - 1].position_m});
  return rest;
}

ComparedRun compare(const scene::SceneDescription& scene, const LabOptions& options,
                    const Contender& contender, const LabRun& reference, double from_s) {
  scene::SceneDescription contended = scene;
  contended.period_s = contender.period_s.value_or(scene.period_s);
  LabOptions own = options;
  own.rival = contender.rival;
  own.transition = contender.transition;
  own.latency_s *= contended.period_s / scene.period_s;
  own.measures_ticks = true;
  const LabRun whole = run_lab(contended, own);
  const LabRun run = from_time(whole, from_s);
  return {.metrics = metrics_of(run, from_time(reference, from_s), 1.0 / contended.period_s),
          .stages = stages(rendered_N(run.rows), run.report.rate_hz),
          .force_rms_N = rms_N(run.rows),
          .longest_period_s = longest_period_s(run.rows),
          .tick_median_s = tick_median_s(run.rows),
          .processor_s_per_s = whole.processor_s / options.duration_s};
}

ComparedRun compare_reference(const LabRun& reference, double from_s) {
  const LabRun run = from_time(reference, from_s);
  const double rate_hz = run.report.rate_hz;
  return {.metrics = metrics_of(run, run, rate_hz),
          .stages = stages(rendered_N(run.rows), rate_hz),
          .force_rms_N = rms_N(run.rows),
          .longest_period_s = longest_period_s(run.rows)};
}

LabRun path_reference(const scene::SceneDescription& scene, const LabOptions& options) {
  const scene::SceneDescription fine = sim_server::true_scene(scene, options.tick_rate_hz);
  LabOptions low_latency = options;
  low_latency.rival = nullptr;
  low_latency.transition = display::Transition::kLocal;
  low_latency.latency_s = low_latency.jitter = 0.0;
  return run_lab(fine, low_latency);
}

}  // namespace stillgrid::laboratory
