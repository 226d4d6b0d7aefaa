#pragma once

#include <Eigen/Core>
#include <span>

#include "haptic_server/rendering/tool_force.hpp"
#include "haptic_server/rendering/touched_spheres.hpp"
#include "proto/scene_segment.hpp"

namespace stillgrid {

/// Of a tool sphere's radius: no sphere yields farther in a tick, for beyond its centre the tool is
/// on the other side, where a push draws.
inline constexpr double kFarthestYield = 0.25;

/// What an image's answers are to.
struct ToolPush {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit, of the tool on the scene; or zero
  double force_N = 0.0;                                 // along it, in the image
};

/// Of a header as it was read; nothing is pushed where that lies. Realtime: yes.
[[nodiscard]] ToolPush tool_push(const proto::SnapshotHeader& snapshot) noexcept;

/// Lets touched spheres yield by so much more. Realtime: yes.
void yield(TouchedSpheres& touched, double change_N) noexcept;

/// Lets touched spheres, which have yielded to a change of `change_N` of the push, yield until the
/// push on those that answer and the change agree, to `tolerance_N`; returns the change that they
/// have yielded to then.
///
/// The push falls as spheres yield, so that the change is met no farther off than push and change
/// differ; there it is found by false position [Dowell, Jarratt 1971: Illinois], in 8 steps at
/// most. Spheres yield a quarter of the tool's radius at most; what is left is the next tick's.
/// Realtime: allocates nothing.
[[nodiscard]] double yield_to_push(const proto::SceneHeader& scene, const ToolPush& push,
                                   std::span<const PlacedToolSphere> tool, const ToolPose& pose,
                                   double change_N, double tolerance_N,
                                   TouchedSpheres& touched) noexcept;

}  // namespace stillgrid
