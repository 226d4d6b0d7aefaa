#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "sim_server/hand_run.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Cost of a candidate and error of its force.
struct Record {
  std::string name = {};
  double work_per_ms = 0.0;                // counted work of a simulated millisecond
  std::optional<double> error_share = {};  // rms of the force's error over the true force's rms
  double truth_error_share = 0.0;          // the same of the truth beside one of half its step
  double latency_share = 0.0;  // lateness of snapshots in the run, in periods, by counted work
  std::size_t spheres = 0;
  std::string refusal = {};  // why the candidate cannot be used; empty: it can
};

/// One way to simulate and to show a scene.
struct Candidate {
  Record record;  // its name
  scene::SceneDescription scene;
  display::Transition transition = display::Transition::kLocal;
};

/// The force that the hand should feel: of true_scene(), each snapshot shown at once.
struct Truth {
  HandRun run;
  // How well it is known: its difference from the same at half the rate, the hand a micrometre
  // beside its path. Some worlds amplify small differences.
  double error_share = 0.0;
};
inline constexpr double kTruth_hz = 8000.0;

/// Returns the scene by velocity_verlet at rate_hz.
[[nodiscard]] scene::SceneDescription true_scene(scene::SceneDescription scene,
                                                 double rate_hz = kTruth_hz);

/// Judges candidates by the force on the scene's own hand. The scene first falls to rest once, for
/// hand->settle_s: where bodies fall to depends on each rounding. Then the truth and each candidate
/// come to rest anew by their own methods, as long again. Errors, costs and lateness come
/// from counts alone, so that records are the same on every machine and on every run.
///
/// Thread: judge() from several at a time. Not real-time.
class Judge {
 public:
  /// Runs the truth. Throws std::runtime_error for a hand that cannot be read, SegmentError.
  /// Pre: scene.hand.
  explicit Judge(const scene::SceneDescription& scene);

  [[nodiscard]] const Truth& truth() const noexcept { return truth_; }
  /// Length of the hand's path that the truth covers.
  [[nodiscard]] double watched_s() const noexcept;

  /// Returns the candidate's record with its work and error. The candidate is run up to kRuns
  /// times, its steps elsewhere in time each time; the worst error and work count.
  /// Snapshots are as late as the work of slow steps makes them. A refusal says why a candidate
  /// cannot be used.
  [[nodiscard]] Record judge(const Candidate& candidate) const;
  static constexpr int kRuns = 4;

 private:
  [[nodiscard]] HandRun truth_at(double rate_hz, double beside_m) const;
  [[nodiscard]] StartState rest_of(const scene::SceneDescription& scene) const;
  [[nodiscard]] Record judge(const Candidate& candidate, const StartState& start) const;

  HandPath hand_;
  scene::SceneDescription scene_;
  bodies::World rest_;  // at the end of the fall
  Truth truth_;
};

}  // namespace stillgrid::sim_server
