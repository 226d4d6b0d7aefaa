#pragma once

#include <limits>

#include "sim_server/choice/record.hpp"
#include "sim_server/hand_run.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// One way to simulate and to show a scene.
struct Candidate {
  choice::Record record;  // its name and settings
  scene::SceneDescription scene;
  display::Transition transition = display::Transition::kPredict;
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

/// A record, and the work that it took to find out.
struct Judgement {
  choice::Record record;
  double work = 0.0;
};

/// When a candidate is known well enough.
struct Enough {
  // Runs end after one of more error, or of more work.
  double error_share = std::numeric_limits<double>::infinity();
  double work_per_ms = std::numeric_limits<double>::infinity();
  // A candidate of more work without predictions is not run with them.
  double most_work_per_ms = std::numeric_limits<double>::infinity();
};

/// Judges candidates by the force on the scene's own hand. The scene first falls to rest once, for
/// hand->settle_s: where bodies fall to depends on each rounding. Then the truth and each candidate
/// come to rest anew by their own methods, as long again. Errors, costs and lateness come
/// from counts alone, so that records are the same on every machine and on every run.
///
/// Thread: judge() from several at a time. Not real-time.
class Judge {
 public:
  /// Runs the truth. It ends early where it has cost more than a quarter of most_work.
  /// Throws std::runtime_error for a hand that cannot be read, SegmentError. Pre: scene.hand.
  Judge(const scene::SceneDescription& scene, double most_work);

  [[nodiscard]] const Truth& truth() const noexcept { return truth_; }
  /// Length of the hand's path that the truth covers.
  [[nodiscard]] double watched_s() const noexcept;

  /// Returns a scene at rest by its own method. A world of other bodies than the truth's falls from
  /// its own start. Throws as settled().
  [[nodiscard]] StartState rest_of(const scene::SceneDescription& scene) const;

  /// Returns the candidate's record with its work and error. The candidate is run up to kRuns
  /// times, its steps elsewhere in time each time; the worst error and work count.
  /// Snapshots are as late as the work of slow steps makes them. A refusal says why a candidate
  /// cannot be used. start: rest_of() its scene.
  [[nodiscard]] Judgement judge(const Candidate& candidate, const StartState& start,
                                const Enough& enough) const;
  /// The same with a start of its own.
  [[nodiscard]] Judgement judge(const Candidate& candidate) const;
  static constexpr int kRuns = 4;

 private:
  [[nodiscard]] HandRun truth_at(double rate_hz, double beside_m, double most_work) const;

  HandPath hand_;
  scene::SceneDescription scene_;
  bodies::World rest_;  // at the end of the fall
  Truth truth_;
};

}  // namespace stillgrid::sim_server
