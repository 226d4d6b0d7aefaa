#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "shared/rendering/force_error.hpp"
#include "tests/laboratory/lab.hpp"

namespace stillgrid::laboratory {

using rendering::kJustNoticeable;
/// From which on a force counts as a contact.
inline constexpr double kContact_N = 0.1;

/// The largest of a set and the one that 99 % do not exceed; zero of none.
struct Extremes {
  double p99 = 0.0, max = 0.0;
};
[[nodiscard]] Extremes extremes_of(std::vector<double> values);

/// Metric 2, N/ms: between neighbours.
[[nodiscard]] Extremes slew_N_per_ms(std::span<const Eigen::Vector3d> forces_N, double rate_hz);

/// Metric 3: a force beside its reference, raw and where the reference is taken so much earlier
/// that they differ least.
struct ForceError {
  double rms_N = 0.0, max_N = 0.0;
  double lag_s = 0.0;  // the effective latency, 0 to 100 ms, in whole ticks
  double rms_at_lag_N = 0.0;
};
/// All three of the same ticks, those that have a reference 100 ms before them.
/// Pre: as many of both.
[[nodiscard]] ForceError force_error(std::span<const Eigen::Vector3d> forces_N,
                                     std::span<const Eigen::Vector3d> reference_N, double rate_hz);

/// Metric 5 of a force's error, all axes: power from 20 to 500 Hz, and how much of it is within two
/// bins of the simulation rate's harmonics.
struct Vibration {
  double power_N2 = 0.0;
  double at_harmonics_N2 = 0.0;
};
[[nodiscard]] Vibration vibration(std::span<const Eigen::Vector3d> error_N, double rate_hz,
                                  double simulation_rate_hz);

/// Metric 4: how long the display stood at a snapshot, waiting for the next.
struct Plateau {
  double share = 0.0;  // of the ticks that show a snapshot
  double longest_s = 0.0;
  double left_over = 0.0;  // the most of a way between snapshots that was cut off by the next one
};
[[nodiscard]] Plateau plateau(std::span<const recording::TickRow> rows, double rate_hz);

/// How unevenly a force changes, as where it stands at a snapshot and then goes on: the change over
/// 10 ms against the mean of those over the 10 ms before and after, over what is just noticeable
/// there. An even change has none, a jump all of itself. Contact that comes and goes, below 0.1 N
/// at either end, is no stage.
struct Stages {
  Extremes jnd;
  double felt_share = 0.0;  // of the time in contact: more than just noticeable
};
[[nodiscard]] Stages stages(std::span<const Eigen::Vector3d> forces_N, double rate_hz);

/// Metric 1, and the same over what is just noticeable in the force there.
struct SwitchMetrics {
  std::size_t count = 0;
  Extremes jump_N, jump_jnd;
};
[[nodiscard]] SwitchMetrics switch_metrics(const LabRun& run);

/// The forces of a run before the safety chain, tick by tick.
[[nodiscard]] std::vector<Eigen::Vector3d> rendered_N(std::span<const recording::TickRow> rows);

/// Metrics 1 to 5 and 7 of a run: of the force as it was rendered, but the energy, which is of the
/// force really held. Metric 6 is a search of many runs; of 8, the age is in the run's report.
struct RunMetrics {
  SwitchMetrics switches;
  Extremes slew_N_per_ms;
  ForceError error;
  Plateau plateau;
  Vibration vibration;
  double energy_given_J = 0.0;
};
/// reference: of run_reference(); the ticks that both have are compared.
[[nodiscard]] RunMetrics metrics_of(const LabRun& run, const LabRun& reference,
                                    double simulation_rate_hz);

}  // namespace stillgrid::laboratory
