#pragma once

#include <optional>
#include <string>
#include <vector>

#include "shared/rendering/renderer.hpp"
#include "sim_server/scene/scene_description.hpp"
#include "tests/laboratory/lab.hpp"
#include "tests/laboratory/path_file.hpp"

namespace stillgrid::fit_run {

/// How a scene is simulated and shown while a hand presses it.
struct Loop {
  scene::SceneDescription scene;
  display::Transition transition = display::Transition::kLocal;
  double latency_share = 0.0;  // periods
};

/// The closed loop at the place where the scene's own hand presses hardest.
struct HeldPress {
  std::optional<bool> stable;  // empty: the hand ends without a contact
  double swing_m = 0.0;        // to and fro in the last half second, peak to peak
  double drift_m = 0.0;        // all motion in that time
  double long_drift_m = 0.0;   // and in the last second
  double truth_swing_m = 0.0;  // velocity_verlet's at 1 kHz; zero: not needed
};

/// Presses a scene where its own hand presses hardest, with a device of that profile in a light
/// hand.
///
/// The scene first follows its own hand, by velocity_verlet at 1 kHz. The world then begins a
/// second before the strongest force. The device follows the path from 2 cm outside and stays 1.5
/// s. It ends so deep that the hand's spring exerts the force, or the device's continuous force.
/// Readings are off by up to half an encoder step.
///
/// The loop is stable if the tool moves by at most four encoder steps in the last half second.
/// Twice the swing of velocity_verlet at 1 kHz, shown at once, is allowed too, and twice its drift
/// of a second. The worst of kSeeds seeds counts.
class Press {
 public:
  static constexpr int kSeeds = 8;

  /// Pre: loop.scene.hand, phantom_profile(profile). Throws as run_lab().
  Press(Loop loop, std::string profile);

  /// All contact stiffnesses times `margin`.
  [[nodiscard]] HeldPress at(double margin) const;
  /// Returns the largest of 1, 1.26, 1.59, 2, ... 16 up to which the loop is stable, if it is at 1.
  [[nodiscard]] std::optional<double> largest_margin() const;

 private:
  [[nodiscard]] HeldPress held(const Loop& loop, double margin, int seed) const;

  Loop loop_;
  std::string profile_;
  double limit_m_ = 0.0;
  laboratory::WorldState start_;
  std::vector<laboratory::PathPoint> path_;  // empty: a hand without contact
};

}  // namespace stillgrid::fit_run
