#pragma once

#include <cstdint>
#include <optional>

#include "tests/laboratory/rivals/local_model.hpp"

namespace stillgrid::laboratory {

/// The one flat surface that stands for all a tool sphere touches, or for the nearest it might.
struct LocalSurface {
  Eigen::Vector3d normal;  // towards the tool
  double depth_m;          // of the tool sphere; negative: its distance
  collision::ContactMaterial material;
  Eigen::Vector3d velocity_m_s;
};

/// Fits the surface at one sphere of the tool; nothing where the patch holds nothing for it.
///
/// Where it touches, normal and depth give the sum of the contacts' springs, and stiffness and
/// damper that sum's derivative along the normal, the contacts' turning apart: with one contact
/// these are the contact's own. Else it is the nearest thing's tangent plane.
/// Realtime: as tool_force().
[[nodiscard]] std::optional<LocalSurface> fit_surface(
    const LocalScene& scene, std::uint32_t tool_sphere,
    const rendering::PlacedToolSphere& probe) noexcept;

/// Adds the contact law's force on a tool sphere that lies depth_m deep under a surface.
void add_surface(rendering::ToolForce& sum, const LocalSurface& surface, double depth_m,
                 const Eigen::Vector3d& normal, const rendering::PlacedToolSphere& probe,
                 const rendering::ToolPose& pose) noexcept;

}  // namespace stillgrid::laboratory
