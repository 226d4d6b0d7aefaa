#pragma once

#include <span>
#include <vector>

#include "proto/scene_segment.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/moving_spheres.hpp"

namespace stillgrid::snapshot {

/// The snapshots of all moving spheres, ready to publish: a grid that holds their history. It is
/// filled anew when swept bounds have outgrown it.
///
/// Nothing is allocated after construction. Thread: one.
class MovingSnapshot {
 public:
  /// Describes the spheres of the world and shows them. voxel_ratio: edge of a voxel over twice the
  /// reach of the spheres' swept bounds; none or negative: chosen from the scene. Throws as show().
  MovingSnapshot(const bodies::World& world, double voxel_ratio);

  /// One more snapshot of every sphere. Throws std::domain_error, naming body and sphere, where a
  /// place is no number. Pre: the world has the bodies that the constructor saw.
  void show(const bodies::World& world);
  /// The same of given states. Pre: states.size() is the count of spheres; numbers.
  void show(std::span<const proto::SphereState> states);

  [[nodiscard]] const collision::VoxelGrid& grid() const noexcept { return spheres_.grid(); }

 private:
  contact::MovingSpheres spheres_;
  std::vector<proto::SphereState> states_;
  std::vector<collision::SweptBound> bounds_;
};

}  // namespace stillgrid::snapshot
