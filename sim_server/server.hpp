#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>

#include "shared/publication/scene_segment.hpp"
#include "shared/publication/segment_watch.hpp"
#include "shared/publication/tool_segment.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/report.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

enum class SimulationClock {
  kReal,      // steps at their deadlines on CLOCK_MONOTONIC
  kLockstep,  // virtual time, in agreement with a haptic_server
  kOffline,   // virtual time, alone, nothing published
};

struct ServerOptions {
  std::string session;
  SimulationClock clock = SimulationClock::kReal;
  std::optional<double> duration_s;  // else until stopped
  double latency_s = 0.0;            // virtual cost of a step: publication follows the sample by it
  double jitter = 0.0;               // each period is drawn from P (1 + u), u uniform in +-jitter
  std::uint64_t seed = 1;
  std::optional<int> cpu;
  int threads = 0;  // that share the work of a large scene; 0: as many as there is room
  std::optional<gid_t> readers;  // a group that may read the scene's segment
  std::function<void()> after_step = [] {};
};

/// Runs a scene until its duration is over or stop is set, and counts what happened in report.
/// lock: of the session's scene segment; none offline.
///
/// Throws SegmentError if memory is short, or if a lockstep peer does not come or dies.
void run_simulation(const scene::SceneDescription& scene, const ServerOptions& options,
                    std::optional<publication::SessionLock> lock, dynamics::Simulation& simulation,
                    SimulationReport& report, const std::atomic<bool>& stop);

}  // namespace stillgrid::sim_server
