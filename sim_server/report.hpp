#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "shared/publication/scene_segment.hpp"
#include "shared/realtime/histogram.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::sim_server {

/// Holds what the report says of one hand.
struct HandReport {
  std::string name;
  double tool_work_J = 0.0;         // that its tool gave, as the snapshots tell it
  realtime::Histogram tool_age_ns;  // of its tool's samples as their snapshots were published,
                                    // virtual in lockstep
  std::optional<proto::RelayFigures> relay;  // of its last tool segment; none: no relay wrote it
};

/// Counters of a run, for --report.
struct SimulationReport {
  std::string scene, solver;
  std::string ended_by;  // what went wrong; empty: the run came to its end, or was stopped
  double rate_hz = 0.0;
  std::uint64_t steps = 0, late_steps = 0, snapshots = 0;
  std::uint64_t states = 0;  // snapshots with a state for local copies
  std::uint64_t left_out_ticks = 0;
  std::uint64_t solver_iterations = 0, not_converged = 0, out_of_budget = 0;
  std::uint64_t substeps = 0, divided = 0;  // parts of all steps, and steps of more than one
  std::uint64_t crossings_left = 0, contacts = 0, sleeping_spheres = 0;
  bool measures_time = false;  // lockstep has no wall time to report
  std::optional<dynamics::EnergyAccount> energy;
  std::vector<HandReport> hands;
  realtime::Histogram step_ns, integrate_ns, publish_ns;
};

/// Returns one line on the steps that did not converge or ran out of time, with advice for the
/// method. Returns an empty text if every step converged in time.
[[nodiscard]] std::string convergence_complaint(const SimulationReport& report,
                                                const scene::Method& method);

/// Returns one line on deadlines that passed without a step, if these are more than half. Returns
/// an empty text otherwise.
[[nodiscard]] std::string lateness_complaint(const SimulationReport& report);

void count_step(SimulationReport& report, const dynamics::StepReport& step);

/// Counts a snapshot that was published for a hand, with a state or without one.
void count_snapshot(SimulationReport& report, std::size_t hand,
                    const publication::SnapshotTimes& times, bool has_state);

/// Writes the report of docs/formats.md, "Reports". Throws std::runtime_error if the file cannot be
/// written.
void write_report(const SimulationReport& report, const bodies::World& world,
                  const std::filesystem::path& file);

/// Writes `body,node,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s`, a row a node; a rigid body as node 0.
/// Throws std::runtime_error if the file cannot be written.
void write_final_state(const bodies::World& world, const std::filesystem::path& file);

}  // namespace stillgrid::sim_server
