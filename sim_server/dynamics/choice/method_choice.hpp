#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim_server/dynamics/choice/predicted_cost.hpp"
#include "sim_server/scene/method.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// Result of one method's trial.
struct MethodTrial {
  scene::Method method;
  std::optional<double> step_ms = {};  // cost of a step by counts, the mean of the trial
  std::optional<double> error_m = {};  // rms of positions at the trial's end
  std::string refusal = {};            // why it was not chosen; empty: chosen
};

/// The method chosen for a scene, with the trials that decided.
struct MethodChoice {
  SceneLoad load;
  scene::Method method;
  std::vector<MethodTrial> trials;
  scene::Method reference;        // whose positions the errors are measured against
  double simulated_s = 0.0;       // of each trial
  double error_floor_m = 0.0;     // of the reference; smaller errors do not rank methods
  bool keeps_rate = false;        // a step costs less than kRateShare of the period
  bool meets_target = false;      // its error; false also where the floor is higher than the target
  double haptic_ms = 0.0;         // cost of a step of 1 ms by velocity_verlet
  bool fits_haptic_rate = false;  // that is less than kHapticShare
};

/// Share of the period that a step of the chosen method may cost.
inline constexpr double kRateShare = 0.7;
/// Share of each millisecond that a scene run at the haptic rate may take.
inline constexpr double kHapticShare = 0.3;

/// Chooses the cheapest method that keeps scene.error_target_m and the scene's rate, from
/// velocity_verlet and implicit_euler in 1, 2 or 4 substeps.
///
/// Each is tried on the scene itself, without a tool, for at most half a second of its time. The
/// trial counts its work: substeps, iterations, products. cost_ms() turns the counts into time; no
/// clock is read, so the choice is the same on every machine. The reference for errors is
/// velocity_verlet at a quarter of the stable step; cvode_bdf where that divides the period more
/// than 10,000 times. tell: called with a line of progress. Not real-time: some seconds.
[[nodiscard]] MethodChoice choose_method(const scene::SceneDescription& scene,
                                         const std::function<void(const std::string&)>& tell);

}  // namespace stillgrid::dynamics
