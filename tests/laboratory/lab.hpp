#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "haptic_server/recording/recorder.hpp"
#include "haptic_server/report.hpp"
#include "haptic_server/safety/device_limits.hpp"
#include "sim_server/scene/scene_description.hpp"
#include "tests/laboratory/network.hpp"
#include "tests/laboratory/rivals/rivals.hpp"
#include "tests/laboratory/world_state.hpp"

namespace stillgrid::laboratory {

/// One closed loop of the laboratory: the options of both servers that decide its course.
struct LabOptions {
  std::string device;            // as haptic_server --device takes it
  const Rival* rival = nullptr;  // none: the product's grid, with its transition
  display::Transition transition = display::Transition::kLocal;
  double tick_rate_hz = 1000.0;
  double latency_s = 0.0;         // virtual cost of a step
  double jitter = 0.0;            // of the simulation's periods
  bool steps_by_samples = false;  // the simulation takes the newest sample once a step
  std::uint64_t seed = 1;         // of jitter and network
  /// Between the two sides; none: both share memory.
  std::optional<NetworkOptions> network = {};
  double duration_s = 10.0;
  safety::SafetyOptions safety = {};
  bool measures_ticks = false;  // by the clock, into rows, report and LabSimulation::step_s; no
                                // force depends on it
  /// Told each tick instead of keeping it in LabRun::rows; false ends the run.
  std::function<bool(const recording::TickRow&)> watch = {};
  const WorldState* start = nullptr;  // of the world at time zero; none: the scene's own
  double state_interval_s = 0.0;      // how often LabRun::states takes the world; 0: never
};

/// A switch of snapshots, as its jump at the same place and time.
struct SwitchJump {
  std::size_t tick = 0;  // row of its run
  double jump_N = 0.0;
};

/// What the simulation had to do.
struct LabSimulation {
  std::size_t spheres = 0, moving_spheres = 0;
  std::uint64_t steps = 0, not_converged = 0;
  std::uint64_t contacts = 0;  // sum over the steps
  std::vector<double> step_s;  // processor time of each step with its snapshot, if measured
};

/// What came of a run, tick by tick.
struct LabRun {
  std::vector<recording::TickRow> rows;
  std::vector<SwitchJump> jumps;
  haptic_server::HapticReport report;
  LabSimulation simulation;
  NetworkFigures network;          // zeros without one
  std::vector<WorldState> states;  // at time zero, then by steps' ends
  double processor_s = 0.0;        // of both sides from the first tick on, by this thread's clock
  bool device_failed = false;      // by a fault, not by the end of its recording
};

/// Runs both servers' product code in this thread, in virtual time: simulation, published segments,
/// haptic loop and device plugin, in the order of lockstep. The rows are to the bit what
/// `sim_server --lockstep` and `haptic_server --lockstep` of the same options record.
///
/// Throws DeviceError, SegmentError. Thread: any, several at a time.
[[nodiscard]] LabRun run_lab(const scene::SceneDescription& scene, const LabOptions& options);

/// The reference of the metrics: the force of the true state, simulated once a tick and shown at
/// once, on the path of the device in `run`. Rows correspond one to one.
[[nodiscard]] LabRun run_reference(const scene::SceneDescription& scene, const LabOptions& options,
                                   const LabRun& run);

}  // namespace stillgrid::laboratory
