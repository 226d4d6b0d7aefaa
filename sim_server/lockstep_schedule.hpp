#pragma once

#include <cstdint>
#include <random>

namespace stillgrid::sim_server {

/// When one snapshot of lockstep is computed and shown, in virtual time: docs/protocol.md,
/// "Lockstep".
struct ScheduledSnapshot {
  std::uint64_t step_ns = 0;     // the step that ends in it
  std::uint64_t state_ns = 0;    // T_n, of what it shows
  std::uint64_t sample_ns = 0;   // S_n, when the simulation takes the tool for it
  std::uint64_t publish_ns = 0;  // P_n, when it is shown
};

/// The snapshots of a lockstep run after the one of time zero, known beforehand: no clock has a
/// say.
class LockstepSchedule {
 public:
  /// Each period is drawn from period_s (1 + u), u uniform in +-jitter, by seed. Publication
  /// follows the sample by latency_s, and the next sample is not taken before it.
  /// first_share: of its period, that the first step takes: where the steps lie in time.
  /// Pre: period_s > 0, 0 <= jitter < 1, latency_s >= 0, 0 < first_share <= 1.
  LockstepSchedule(double period_s, double jitter, std::uint64_t seed, double latency_s,
                   double first_share = 1.0);

  /// The next snapshot, the first by the first call.
  [[nodiscard]] ScheduledSnapshot next();

 private:
  double period_s_;
  double share_;  // of the next step
  std::uint64_t latency_ns_;
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> spread_;
  ScheduledSnapshot last_;
};

}  // namespace stillgrid::sim_server
