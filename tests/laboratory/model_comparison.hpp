#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim_server/scene/scene_description.hpp"
#include "tests/laboratory/lab.hpp"
#include "tests/laboratory/metrics.hpp"

namespace stillgrid::laboratory {

/// What is set side by side: a model, and where it is the simulation that is to be fast, its
/// period.
struct Contender {
  std::string name;
  const Rival* rival = nullptr;                                 // none: the grid
  display::Transition transition = display::Transition::kHold;  // of the grid
  std::optional<double> period_s = {};                          // none: the scene's
};

/// The grid with every transition, every rival, and held snapshots "simulated as fast as a step
/// allows": at 250 Hz, 500 Hz and 1 kHz.
[[nodiscard]] std::vector<Contender> contenders();

/// The run from from_s on, as if it had begun then; its energy is of the force held since.
[[nodiscard]] LabRun from_time(const LabRun& run, double from_s);

/// What one contender came to on a path of the device.
struct ComparedRun {
  RunMetrics metrics;
  Stages stages;
  double force_rms_N = 0.0;
  double longest_period_s = 0.0;   // between snapshots, by their publication
  double tick_median_s = 0.0;      // in contact, by the clock; no repeatable figure
  double processor_s_per_s = 0.0;  // of both sides, a simulated second; likewise
};

/// The course of a contender: scene and options with its model, transition and period. A step
/// costs the same share of any period. options.latency_s: with the scene's period.
[[nodiscard]] ComparedRun compare(const scene::SceneDescription& scene, const LabOptions& options,
                                  const Contender& contender, const LabRun& reference,
                                  double from_s);

/// What a reference is by itself: of no error, and no time.
[[nodiscard]] ComparedRun compare_reference(const LabRun& reference, double from_s);

/// The reference on the path of options.device, which takes no notice of forces: every contender
/// is measured against it. It is sim_server::true_scene() at the tick rate, by local.
[[nodiscard]] LabRun path_reference(const scene::SceneDescription& scene,
                                    const LabOptions& options);

}  // namespace stillgrid::laboratory
