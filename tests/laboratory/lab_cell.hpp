#pragma once

#include <optional>
#include <string>

#include "sim_server/scene/scene_description.hpp"
#include "tests/laboratory/lab.hpp"
#include "tests/laboratory/lab_scenes.hpp"
#include "tests/laboratory/stable_stiffness.hpp"
#include "tests/laboratory/verdict.hpp"

namespace stillgrid::laboratory {

/// Of a cell that is given none.
inline constexpr double kAnyStiffness_N_per_m = 1000.0;

/// A cell of the maps: a closed loop but for its contact stiffness. Texts are checked when the cell
/// is used.
struct LabCell {
  std::string scene = "wall";    // a body of lab_scenes.hpp with :KG if any, or a scene FILE.toml
  std::string tool = "1x1";      // or 2x2, 3x1; of our scenes
  std::string device = "light";  // light, hand, none, or as haptic_server --device takes it
  std::string limits = "none";   // or declared: by light, hand, none of force, slew, friction
  std::string from = "inside";   // in contact; or outside: light, hand, none come from 10 mm above
  std::string transition = "local", model = "grid";
  double period_s = 0.01;      // of the simulation
  double latency_share = 0.0;  // what a step costs, of the period
  double jitter = 0.0;
  bool steps_by_samples = false;  // as LabOptions
  NetworkOptions network = {};    // both sides share memory where it does nothing
  std::uint64_t seed = 1;         // of jitter and network
  int seeds = 8;                // of a verdict: seed and those after it, the worst of which counts
  double resolution_m = 30e-6;  // of the encoders, and
  double device_friction_N = 0.0;          // of light, hand and none that declare no limits
  double contact_damping_N_s_per_m = 0.0;  // of our scenes, and
  std::optional<double> friction = {};     // none: that of the body
  double duration_s = 20.0;                // of a run at least; one that dies away has three times
};

/// The file that a cell's scene is, with that stiffness; a scene of ours only. Throws
/// std::runtime_error.
[[nodiscard]] std::string scene_text_of(const LabCell& cell, double stiffness_N_per_m);

/// The cell's scene. stiffness_N_per_m: in ours that of the contact with all the tool's spheres, of
/// a file that of its first material; none: as the file says, or 1000 N/m. Throws
/// std::runtime_error.
[[nodiscard]] scene::SceneDescription scene_of(const LabCell& cell,
                                               std::optional<double> stiffness_N_per_m);

/// Whether its course hangs on the seed.
[[nodiscard]] bool is_drawn(const LabCell& cell) noexcept;

/// Throws std::runtime_error that names the option and its value.
[[nodiscard]] LabOptions options_of(const LabCell& cell);

/// Of the contact with the tool: the cell's own, or its body's.
[[nodiscard]] double friction_of(const LabCell& cell);

/// Judged over two cycles of the hand on its spring with all that moves in the scene: no mode of
/// the loop is slower. A device of the user's own has no known hand: a second.
[[nodiscard]] VerdictRule rule_of(const LabCell& cell);

/// One run of the cell by its first seed.
[[nodiscard]] Verdict verdict_of(const LabCell& cell, double stiffness_N_per_m);

/// Metric 6 of a cell.
struct CellLimit {
  std::optional<double> limit_N_per_m;  // none: the lowest stiffness is lost
  Verdict lost_by = Verdict::kStable;   // of the first loss; stable: none up to the highest
  /// By as many other seeds, looked for from 0.7 of the limit to 1.4 of it; none: below.
  std::optional<double> by_others_N_per_m;
  double processor_s = 0.0;
};

/// The last stiffness before the first that is lost by any of the seeds; where nothing is drawn all
/// are alike.
[[nodiscard]] CellLimit limit_of(const LabCell& cell, const StiffnessSearch& search);

}  // namespace stillgrid::laboratory
