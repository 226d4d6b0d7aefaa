#pragma once

#include <optional>
#include <string>

#include "shared/tools/laboratory/lab.hpp"
#include "shared/tools/laboratory/lab_scenes.hpp"
#include "shared/tools/laboratory/stable_stiffness.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::laboratory {

/// A cell of the maps: a closed loop but for its contact stiffness. Texts are checked when the cell
/// is used.
struct LabCell {
  std::string scene = "wall";    // wall, free[:KG], chain[:KG], block[:KG], or a scene FILE.toml
  std::string device = "light";  // light, hand, none, or as haptic_server --device takes it
  std::string transition = "predict", model = "grid";
  double period_s = 0.01;      // of the simulation
  double latency_share = 0.0;  // what a step costs, of the period
  double jitter = 0.0;
  std::uint64_t seed = 1;       // of the jitter
  int seeds = 8;                // of a verdict: seed and those after it, the worst of which counts
  double resolution_m = 30e-6;  // of the encoders, and
  double device_friction_N = 0.0;                          // of light, hand and none
  double contact_damping_N_s_per_m = 0.0, friction = 0.0;  // of wall, free, chain and block
  double duration_s = 20.0;
};

/// The file that a cell's scene is, with that stiffness; a scene of ours only. Throws
/// std::runtime_error.
[[nodiscard]] std::string scene_text_of(const LabCell& cell, double stiffness_N_per_m);

/// The cell's scene. stiffness_N_per_m: of its first material, in ours that of the contact with the
/// tool; none: as the file says, or 1000 N/m. Throws std::runtime_error.
[[nodiscard]] scene::SceneDescription scene_of(const LabCell& cell,
                                               std::optional<double> stiffness_N_per_m);

/// Throws std::runtime_error that names the option and its value.
[[nodiscard]] LabOptions options_of(const LabCell& cell);

/// Metric 6 of the cell: the least over its seeds, which without jitter are all alike.
[[nodiscard]] std::optional<double> largest_stable_stiffness_N_per_m(const LabCell& cell,
                                                                     const StiffnessSearch& search);

}  // namespace stillgrid::laboratory
