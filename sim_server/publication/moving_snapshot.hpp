#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "proto/scene_segment.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/detection.hpp"

namespace stillgrid {

/// The snapshot of all moving spheres, ready to publish, in the grid that finds their contacts: one
/// grid serves both [Davanne 2002, section 2], its covers growing by what a snapshot needs more.
///
/// Nothing is allocated after construction. Thread: one.
class MovingSnapshot {
 public:
  MovingSnapshot() = default;
  /// Describes the spheres of the world and shows them where detection sees them. Pre: detection
  /// was made for this world.
  MovingSnapshot(const World& world, Detection& detection);

  /// One more image of every sphere, as detection.motions() has it: the grid then holds the whole
  /// history. Pre: detection is the constructor's.
  void show(Detection& detection);
  /// The same of given images. Pre: the spheres were entered, images.size() is their count.
  void show(std::span<const proto::SphereImage> images, MovingSpheres& spheres);

  /// Adds to the image shown last where each sphere will go, though contacts were looked for since:
  /// covers hold all images, and from lag_s before the newest to drift_s after it on the drift.
  /// Pre: foresight.size() is the count.
  void foretell(std::span<const SphereForesight> foresight, double drift_s, double lag_s,
                MovingSpheres& spheres);

 private:
  std::vector<proto::SphereImage> images_;
  std::uint64_t shown_entry_ =
      0;  // of MovingSpheres::entered_count(), whose covers hold the history
};

}  // namespace stillgrid
