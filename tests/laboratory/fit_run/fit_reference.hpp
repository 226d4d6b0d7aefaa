#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim_server/scene/scene_description.hpp"
#include "tests/laboratory/lab.hpp"

namespace stillgrid::fit_run {

/// What a candidate and its reference have in common: how the device moves, and for how long.
struct FitPath {
  std::filesystem::path trajectory;
  std::string replay = {};                // more options of the replay device, separated by commas
  std::optional<double> duration_s = {};  // none: to the trajectory's end
};

/// The options of a run along the path. Throws std::runtime_error for a file's name with a comma.
[[nodiscard]] laboratory::LabOptions path_options(const FitPath& path);

/// A place of the path where the tool presses hard, and the world somewhat before.
struct ReferencePress {
  double begin_s = 0.0;  // of the run, when `world` was so
  double press_s = 0.0;
  laboratory::WorldState world;
};

/// The truth that candidates are measured against, and where they start.
struct FitReference {
  double settle_s = 0.0;
  laboratory::WorldState start;          // at the run's time zero
  std::vector<recording::TickRow> rows;  // time, position, rendered force, contacts; one a tick
  std::vector<ReferencePress> presses;
};

/// The scene by the reference's method: implicit Euler, solved by Newton to 1e-8 m/s, so many steps
/// a millisecond.
[[nodiscard]] scene::SceneDescription reference_scene(const scene::SceneDescription& scene,
                                                      int steps_per_tick);

/// Runs the reference: the scene settles for settle_s without the tool, at 1 kHz, then follows the
/// path, each snapshot shown at once. `run`: what came of it besides.
[[nodiscard]] FitReference make_reference(const scene::SceneDescription& scene, const FitPath& path,
                                          int steps_per_tick, double settle_s,
                                          laboratory::LabRun& run);

/// Up to three ticks with the strongest forces, half a second apart, strongest first; none below a
/// tenth of the strongest.
[[nodiscard]] std::vector<std::size_t> strongest_presses(
    const std::vector<recording::TickRow>& rows);

/// REF.csv has its worlds in REF.state.csv.
[[nodiscard]] std::filesystem::path state_file_of(const std::filesystem::path& file);

/// Writes both files. Throws std::runtime_error if they cannot be written.
void write_reference(const std::filesystem::path& file, const scene::SceneDescription& scene,
                     const FitReference& reference);

/// Reads both, to the bit. Throws std::runtime_error, one line, for what is no such file, or of a
/// scene with other bodies.
[[nodiscard]] FitReference read_reference(const std::filesystem::path& file,
                                          const scene::SceneDescription& scene);

}  // namespace stillgrid::fit_run
