#include "sim_server/explain.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

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

std::string row(const dynamics::MethodTrial& trial) {
  const std::string mark = trial.refusal.empty() && trial.error_m ? "* " : "  ";
  const auto error_mm = trial.error_m ? std::optional<double>(1e3 * *trial.error_m) : std::nullopt;
  return mark + print("%-36s", scene::describe(trial.method).c_str()) + cell(trial.predicted_ms) +
         cell(trial.measured_ms) + cell(trial.slow_ms) + cell(error_mm) + "  " +
         (trial.refusal.empty() ? "chosen" : trial.refusal) + '\n';
}

}  // namespace

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
  const double limit_ms = 1e3 * dynamics::symplectic_limit_s(load);
  std::string text = print(
      "%s: %.0f nodes, %.0f springs, %.0f rigid bodies, %.0f moving spheres\n"
      "stiffest: springs %.3g rad/s, contacts %.3g rad/s; symplectic_euler is stable below about "
      "%.3g ms\n"
      "period %.4g ms, error target %.3g mm rms; each method tried over %.3g s, errors below %.2g "
      "mm do not tell them apart\n\n",
      scene.name.c_str(), load.nodes, load.springs, load.rigid_bodies, load.spheres,
      load.spring_rad_s, load.contact_rad_s, limit_ms, 1e3 * scene.period_s,
      1e3 * scene.error_target_m, choice.simulated_s, 1e3 * choice.error_floor_m);
  text += print("  %-36s%10s%10s%10s%10s  %s\n", "method", "predicted", "measured", "9 of 10",
                "error", "");
  text += print("  %-36s%10s%10s%10s%10s\n", "", "ms a step", "ms a step", "ms a step", "mm");
  for (const dynamics::MethodTrial& trial : choice.trials) text += row(trial);
  text += "\nchosen: " + scene::describe(choice.method) + '\n';
  if (!choice.keeps_rate) text += "no method keeps the rate with room to spare\n";
  if (const std::string complaint = target_complaint(choice, scene); !complaint.empty())
    text += complaint + '\n';
  text +=
      "errors of methods that were stopped are not known: each had cost half again as much as "
      "one that keeps the target\n";
  text += print("at 1 kHz a step of velocity_verlet costs %.3g ms, ", choice.haptic_ms);
  text +=
      choice.fits_haptic_rate
          ? "so cheap that integrator = \"velocity_verlet\" and --rate 1000 simulate the scene at "
            "the haptic rate itself: no transition between snapshots is needed then\n"
          : "too much for the haptic rate: two rates are needed\n";
  return text;
}

}  // namespace stillgrid::sim_server
