#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim_server/dynamics/choice/predicted_cost.hpp"
#include "sim_server/scene/method.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// What became of one method in the choice.
struct MethodTrial {
  scene::Method method;
  std::optional<double> predicted_ms =
      {};                                  // a step's cost, by counting; none: no prediction needed
  std::optional<double> measured_ms = {};  // a step's cost, median of the trial
  std::optional<double> slow_ms = {};      // 9 of 10 steps cost no more
  std::optional<double> error_m =
      {};                    // of positions at the trial's end, rms, against the reference
  std::string refusal = {};  // why it was not chosen; empty: chosen
};

/// The method chosen for a scene, and what was seen on the way.
struct MethodChoice {
  SceneLoad load;
  scene::Method method;
  std::vector<MethodTrial> trials;  // cheapest prediction first; then those refused untried
  double simulated_s = 0.0;         // of each trial
  double error_floor_m = 0.0;       // of the reference: smaller errors do not tell methods apart
  bool keeps_rate = false;          // 9 of 10 of its steps, with room to spare
  bool meets_target = false;        // its error; where the floor is higher nobody can tell
  double haptic_ms = 0.0;           // cost of a step of 1 ms by velocity_verlet, 9 of 10
  bool fits_haptic_rate = false;  // simulated at 1 kHz it takes less than kHapticShare of the time
};

/// Share of each millisecond that a scene run at the haptic rate may take.
inline constexpr double kHapticShare = 0.3;

/// Chooses the cheapest method that keeps scene.error_target_m and the scene's rate.
///
/// Stiffness, masses and step predict each method's cost and whether it is stable at all; the
/// promising ones are tried on the scene itself, without a tool, for half a second of its time or
/// less, against a reference of a quarter of the stable step. A method that has become half again
/// as expensive as the best so far is not tried to its end.
/// now_s: a clock; it decides, so that two choices may differ: record one for virtual time
/// (sim_server/method_record.hpp). tell: called with a line of progress. Not real-time: some
/// seconds.
[[nodiscard]] MethodChoice choose_method(const scene::SceneDescription& scene,
                                         const std::function<double()>& now_s,
                                         const std::function<void(const std::string&)>& tell);

}  // namespace stillgrid::dynamics
