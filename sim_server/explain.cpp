#include "sim_server/explain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "shared/rendering/force_error.hpp"

namespace stillgrid::sim_server {
namespace {

template <class... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 400> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

std::string cell(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? print("%10.3g", *value) : "         -";
}

std::string row(const RateTrial& trial) {
  const auto times = [&](double factor, const std::optional<double>& value) {
    return value ? std::optional(factor * *value) : std::nullopt;
  };
  return (trial.refusal.empty() ? "* " : "  ") + print("%10.4g", trial.rate_hz) +
         cell(times(100.0, trial.processor_share)) + cell(times(100.0, trial.error_share)) +
         cell(times(1.0 / rendering::kJustNoticeable, trial.error_share)) +
         print("%10d", trial.runs) + "  " + (trial.refusal.empty() ? "chosen" : trial.refusal) +
         '\n';
}

std::string row(const dynamics::MethodTrial& trial) {
  const auto error_mm = trial.error_m ? std::optional<double>(1e3 * *trial.error_m) : std::nullopt;
  return (trial.refusal.empty() ? "* " : "  ") +
         print("%-28s", scene::describe(trial.method).c_str()) + cell(trial.step_ms) +
         cell(error_mm) + "  " + (trial.refusal.empty() ? "chosen" : trial.refusal) + '\n';
}

std::string row(const fields::ContactTrial& trial) {
  return (trial.refusal.empty() ? "* " : "  ") +
         print("%-26s%10zu%10.3g%10.3g%10.3g%10.3g%10.3g", fields::describe(trial).c_str(),
               trial.parts, trial.bytes / 1048576.0, 1e-3 * trial.tick_ns, 1e-3 * trial.step_ns,
               1e-3 * trial.cost_ns, trial.error_share / rendering::kJustNoticeable) +
         "  " + (trial.refusal.empty() ? "chosen" : trial.refusal) + '\n';
}

}  // namespace

std::string explain_contacts(const scene::SceneDescription& scene) {
  std::string text;
  for (const bodies::BodyDescription& body : scene.bodies) {
    const auto* const mesh = std::get_if<bodies::RigidMeshBody>(&body.shape);
    if (mesh == nullptr || mesh->trials.empty()) continue;
    text += print(
        "contact of %s, by counts; its force may err by %.3g JND\n\n"
        "  %-26s%10s%10s%10s%10s%10s%10s\n  %-26s%10s%10s%10s%10s%10s%10s\n",
        body.name.c_str(), mesh->asked_field->max_error_share / rendering::kJustNoticeable, "model",
        "bricks or", "memory", "a tick", "a step", "a ms", "error", "", "spheres", "MiB", "us",
        "us", "us", "JND");
    for (const fields::ContactTrial& trial : mesh->trials) text += row(trial);
    text += '\n';
  }
  return text;
}

std::string target_complaint(const dynamics::MethodChoice& choice,
                             const scene::SceneDescription& scene) {
  if (choice.meets_target) return "";
  return choice.error_floor_m > 0.5 * scene.error_target_m
             ? "whether the method meets the error target cannot be told: the scene itself makes "
               "small differences larger than that"
             : "no method in time meets the error target: this is the most accurate";
}

std::string explain(const dynamics::MethodChoice& choice, const scene::SceneDescription& scene) {
  const dynamics::SceneLoad& load = choice.load;
  std::string text = print(
      "%s: %.0f nodes, %.0f springs, %.0f rigid bodies, %.0f moving spheres\n"
      "stiffest: springs %.3g rad/s, contacts %.3g rad/s; velocity_verlet is stable below about "
      "%.3g ms\n"
      "period %.4g ms, error target %.3g mm rms; each method tried over %.3g s against %s, errors "
      "below %.2g mm do not rank them\n\n",
      scene.name.c_str(), load.nodes, load.springs, load.rigid_bodies, load.spheres,
      load.spring_rad_s, load.contact_rad_s, 1e3 * dynamics::stable_step_s(load),
      1e3 * scene.period_s, 1e3 * scene.error_target_m, choice.simulated_s,
      scene::describe(choice.reference).c_str(), 1e3 * choice.error_floor_m);
  text +=
      print("  %-28s%10s%10s\n  %-28s%10s%10s\n", "method", "cost", "error", "", "ms a step", "mm");
  for (const dynamics::MethodTrial& trial : choice.trials) text += row(trial);
  text += "\nchosen: " + scene::describe(choice.method) + "; costs are counts, not times\n";
  if (!choice.keeps_rate) text += "no method keeps the rate with room to spare\n";
  if (const std::string complaint = target_complaint(choice, scene); !complaint.empty())
    text += complaint + '\n';
  text += print("at 1 kHz a step of velocity_verlet costs %.3g ms, ", choice.haptic_ms);
  text += choice.fits_haptic_rate
              ? "so integrator = \"velocity_verlet\" and rate_hz = 1000 simulate the scene at the "
                "haptic rate itself\n"
              : "too much for the haptic rate: two rates are needed\n";
  return text;
}

std::string force_complaint(const RateChoice& choice, const scene::SceneDescription& scene) {
  if (!choice.keeps_share)
    return print("no rate costs less than %.3g of a processor: this is the cheapest",
                 scene.processor_share);
  if (choice.keeps_force) return "";
  const auto is_known = [](const RateTrial& trial) { return trial.error_share.has_value(); };
  if (std::ranges::none_of(choice.trials, is_known))
    return print(
        "by how much the force errs is not known: the hand touched nothing in the %.3g s "
        "that were watched",
        choice.watched_s);
  return print(
      "no rate within %.3g of a processor keeps the force within a just noticeable "
      "difference: this is the most accurate",
      scene.processor_share);
}

std::string explain(const RateChoice& choice, const scene::SceneDescription& scene) {
  std::string text = print(
      "rates, by %s, for the hand of %s over %.3g s; at most %.3g %% of a processor\n\n"
      "  %10s%10s%10s%10s%10s\n  %10s%10s%10s%10s\n",
      scene::describe(scene.method).c_str(), scene.hand->file.filename().c_str(), choice.watched_s,
      100.0 * scene.processor_share, "rate", "processor", "error", "error", "runs", "Hz", "%",
      "% force", "JND");
  for (const RateTrial& trial : choice.trials) text += row(trial);
  text += print("\nrate: %.4g Hz", choice.rate_hz);
  if (!scene.choose_rate) text += print("; the scene has %.4g Hz", 1.0 / scene.period_s);
  text += '\n';
  if (const std::string complaint = force_complaint(choice, scene); !complaint.empty())
    text += complaint + '\n';
  return text;
}

}  // namespace stillgrid::sim_server
