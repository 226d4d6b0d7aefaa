#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "proto/scene_segment.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/detection.hpp"

namespace stillgrid::snapshot {

/// The snapshot of all moving spheres, ready to publish, in the grid that finds their contacts: one
/// grid serves both [Davanne 2002, section 2], its swept bounds growing by what a snapshot needs
/// more.
///
/// Nothing is allocated after construction. Thread: one.
class MovingSnapshot {
 public:
  MovingSnapshot() = default;
  /// Describes the spheres of the world and shows them where detection sees them. Pre: detection
  /// was made for this world.
  MovingSnapshot(const bodies::World& world, contact::Detection& detection);

  /// One more snapshot of every sphere, as detection.motions() has it: the grid then holds the
  /// whole history. Pre: detection is the constructor's.
  void show(contact::Detection& detection);
  /// The same of given snapshots. Pre: the spheres were entered, snapshots.size() is their count.
  void show(std::span<const proto::SphereState> snapshots, contact::MovingSpheres& spheres);

  /// Adds to the snapshot shown last where spheres will go: prediction[k] of sphere spheres[k], the
  /// others at their velocity. Swept bounds hold all snapshots, and from lag_s before the newest to
  /// prediction_s after it on the drift. Pre: `spheres` ascend; the grid was not entered anew
  /// since.
  void take_predictions(std::span<const std::uint32_t> spheres,
                        std::span<const bodies::SpherePrediction> prediction, double prediction_s,
                        double lag_s, contact::MovingSpheres& moving);

  /// All of the snapshot shown last go on at their velocity again. Swept bounds stay.
  static void forget_predictions(contact::MovingSpheres& moving);

 private:
  std::vector<proto::SphereState> snapshots_;
  std::uint64_t shown_entry_ =
      0;  // of MovingSpheres::entered_count(), whose swept bounds hold the history
};

}  // namespace stillgrid::snapshot
