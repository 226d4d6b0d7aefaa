#pragma once

#include <Eigen/Core>
#include <span>

#include "proto/scene_segment.hpp"
#include "shared/rendering/tool_force.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Of a tool sphere's radius: no sphere gives way farther in a tick, for beyond its centre the tool
/// is on the other side, where a push draws.
inline constexpr double kMaxCompliantShift = 0.25;

/// What a snapshot's compliances are to.
struct ToolPush {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit, of the tool on the scene; or zero
  double force_N = 0.0;                                 // along it, in the snapshot
};

/// Of a header as it was read; nothing is pushed where that lies. Realtime: yes.
[[nodiscard]] ToolPush tool_push(const proto::SnapshotHeader& snapshot) noexcept;

/// Lets touched spheres give way by so much more. Realtime: yes.
void apply_compliance(TouchedSpheres& touched, double change_N) noexcept;

/// Lets touched spheres, which have given way to a change of `change_N` of the push, give way until
/// the push on those that are compliant and the change agree, to `tolerance_N`; returns the change
/// that they have given way to then.
///
/// The push falls as spheres give way, so that the change is met no farther off than push and
/// change differ; there it is found by false position [Dowell, Jarratt 1971: Illinois], in 8 steps
/// at most. Spheres give way a quarter of the tool's radius at most; what is left is the next
/// tick's. Realtime: allocates nothing.
[[nodiscard]] double solve_compliance(const proto::SceneHeader& scene, const ToolPush& push,
                                      std::span<const PlacedToolSphere> tool, const ToolPose& pose,
                                      double change_N, double tolerance_N,
                                      TouchedSpheres& touched) noexcept;

}  // namespace stillgrid::rendering
