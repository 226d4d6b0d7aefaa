#include "tests/laboratory/fit_run/fit_json.hpp"

#include <nlohmann/json.hpp>

#include "tests/laboratory/fit_run/fit_error.hpp"
#include "tests/laboratory/metrics.hpp"

namespace stillgrid::fit_run {
namespace {

using Json = nlohmann::ordered_json;

Json or_null(const std::optional<double>& value, double factor = 1.0) {
  return value ? Json(factor * *value) : Json(nullptr);
}

Json settings_json(const FitSettings& settings) {
  return {{"set", settings.set},
          {"transition", settings.transition},
          {"latency_share", or_null(settings.latency_share)},
          {"settle_s", settings.settle_s},
          {"trajectory", settings.trajectory},
          {"replay", settings.replay},
          {"scene", settings.scene},
          {"method", settings.method},
          {"rate_hz", settings.rate_hz}};
}

Json reference_json(const FitReference& reference) {
  const FitReferenceForce force = reference_force(reference.rows);
  Json presses = Json::array();
  for (const ReferencePress& press : reference.presses) presses.push_back(press.press_s);
  return {
      {"force_rms_N", force.rms_N}, {"contact_share", force.contact_share}, {"presses_s", presses}};
}

Json error_json(const FitError& error) {
  return {{"rms_N", or_null(error.rms_N)},
          {"share", or_null(error.share)},
          {"rms_at_lag_share", or_null(error.rms_at_lag_share)},
          {"lag_ms", or_null(error.lag_s, 1e3)},
          {"jnd", or_null(error.share, 1.0 / laboratory::kJustNoticeable)},
          {"jnd_p95", or_null(error.jnd_p95)},
          {"felt_share", or_null(error.felt_share)}};
}

Json cost_json(const FitCost& cost, int repeats) {
  return {{"processor_us_per_ms", cost.processor_us_per_ms},
          {"simulation_us_per_ms", cost.simulation_us_per_ms},
          {"tick_us", {{"p50", cost.tick_p50_us}, {"p99", cost.tick_p99_us}}},
          {"step_ms", {{"p50", cost.step_p50_ms}, {"p95", cost.step_p95_ms}}},
          {"step_share", cost.step_share},
          {"repeats", repeats}};
}

Json counts_json(const laboratory::LabSimulation& simulation) {
  const double steps = static_cast<double>(simulation.steps > 0 ? simulation.steps : 1);
  return {{"spheres", simulation.spheres},
          {"moving_spheres", simulation.moving_spheres},
          {"steps", simulation.steps},
          {"contacts_mean", static_cast<double>(simulation.contacts) / steps},
          {"not_converged", simulation.not_converged}};
}

Json stability_json(const FitStabilityResult& stability) {
  Json json = {{"profile", stability.profile},
               {"margin", stability.margin},
               {"stable", stability.found.stable ? Json(*stability.found.stable) : Json(nullptr)},
               {"swing_m", stability.found.swing_m},
               {"reference_swing_m", or_null(stability.found.reference_swing_m)},
               {"contact_share", stability.found.contact_share}};
  if (stability.searched) json["largest_margin"] = or_null(stability.largest_margin);
  return json;
}

/// A file's name may be no UTF-8.
std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string json_line(const FitSettings& settings, const FitReference& reference,
                      const FitResult& result, int repeats,
                      const std::optional<FitStabilityResult>& stability) {
  return line_of({{"settings", settings_json(settings)},
                  {"reference", reference_json(reference)},
                  {"error", error_json(result.error)},
                  {"switch_jump_jnd_max", or_null(result.switch_jump_jnd_max)},
                  {"stage_felt_share", or_null(result.stage_felt_share)},
                  {"cost", result.cost ? cost_json(*result.cost, repeats) : Json(nullptr)},
                  {"counts", counts_json(result.simulation)},
                  {"stability", stability ? stability_json(*stability) : Json(nullptr)},
                  {"problems", result.problems}});
}

std::string json_line(const FitSettings& settings, const FitReference& reference,
                      const laboratory::LabRun& run, double period_s) {
  Json problems = Json::array();
  if (!(reference_force(reference.rows).rms_N > 0.0))
    problems.push_back("the trajectory touches nothing in the reference");
  return line_of({{"settings", settings_json(settings)},
                  {"reference", reference_json(reference)},
                  {"cost", cost_json(cost_of(run, period_s), 1)},
                  {"counts", counts_json(run.simulation)},
                  {"problems", problems}});
}

}  // namespace stillgrid::fit_run
