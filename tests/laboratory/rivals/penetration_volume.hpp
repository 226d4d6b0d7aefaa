#pragma once

#include <Eigen/Core>
#include <span>

#include "shared/rendering/tool_force.hpp"
#include "sim_server/spheres/force_map.hpp"

namespace stillgrid::laboratory {

/// The lens in which two spheres overlap: its volume and centroid, which lies on the line of the
/// centres.
struct SphereOverlap {
  double volume_m3 = 0.0;
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
};

/// In closed form; the smaller sphere itself where the other contains it, volume 0 where they do
/// not overlap or a number is none. Continuous, and once differentiable by the distance.
/// Realtime: yes. Pre: radii >= 0.
[[nodiscard]] SphereOverlap overlap_of(const spheres::Ball& a, const spheres::Ball& b) noexcept;

/// A body whose contacts push by the volume of their overlap instead of its depth [Weller and
/// Zachmann, Inner Sphere Trees, 2009]. Body's own frame.
///
/// Each pair of a tool sphere and a ball pushes by pressure stiffness (N/m^3) times their overlap's
/// volume, along the line of the centres, at the overlap's centroid. The paper's spheres do not
/// overlap each other; of balls that do, each counts what they share.
struct VolumeBody {
  spheres::BallBody balls;     // made for the tool's largest sphere
  double pressure_per_m2 = 0;  // pressure stiffness for 1 N/m of the material, so per m^2
};

/// A body that is as stiff as its material, as the mean over the surface: the slope of the normal
/// force of a tool sphere of the body's tool radius at that depth is the material's stiffness, as
/// spheres::stiffness_scale() makes it for spheres. Throws std::runtime_error where the balls do
/// not push back. Pre: surface not empty, press_depth_m > 0.
[[nodiscard]] VolumeBody make_volume_body(std::span<const spheres::Ball> balls,
                                          const spheres::SurfaceSamples& surface,
                                          double tool_radius_m, double press_depth_m);

/// The force on a still tool sphere of the body's tool radius, for a material of 1 N/m: as
/// spheres::UnitForce. Over any closed path its work is zero: each pair's force depends on its
/// distance alone. Realtime: as spheres::unit_force_m().
[[nodiscard]] Eigen::Vector3d unit_volume_force_m(const VolumeBody& body,
                                                  const Eigen::Vector3d& tool_m) noexcept;

/// Force and torque on a tool of several spheres, the body at rest: the volume's push in the place
/// of the contact law's spring, its damper and friction as they are.
///
/// tool: placed at `pose` in the body's frame. Stiffness and stored energy are left zero: they are
/// those of the spring. Realtime: as unit_volume_force_m().
/// Pre: no sphere of the tool larger than the body's tool radius.
[[nodiscard]] rendering::ToolForce volume_force(const VolumeBody& body,
                                                const collision::ContactMaterial& material,
                                                std::span<const rendering::PlacedToolSphere> tool,
                                                const rendering::ToolPose& pose) noexcept;

}  // namespace stillgrid::laboratory
