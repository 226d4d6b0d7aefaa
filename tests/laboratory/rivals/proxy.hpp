#pragma once

#include <array>
#include <span>

#include "tests/laboratory/rivals/local_surface.hpp"

namespace stillgrid::laboratory {

/// A god-object for each sphere of the tool: a centre that goes to the tool's as near as it can and
/// stays outside the patch's spheres, grown by the tool sphere's radius, and above the planes. The
/// force is that of a spring from the tool to it [Zilles 1995; on local spheres Mendoza 2001].
///
/// Each tick looks for the nearest place to the tool in the intersection of the half-spaces that
/// touch the spheres towards the god-object. A half-space lies wholly outside its sphere and the
/// intersection is convex, so no step passes through anything, however thin.
class Proxy final : public LocalModel {
 public:
  void widen(std::span<rendering::PlacedToolSphere> balls) const noexcept override;
  void update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool& present,
              bool is_first) noexcept override;
  [[nodiscard]] rendering::ToolForce force(const LocalScene& scene,
                                           const PlacedTool& tool) noexcept override;

 private:
  struct HalfSpace {
    Eigen::Vector3d normal;
    double offset_m;  // normal . x >= offset_m is free
    double push_m;    // how far it pushes the place from the tool's
    std::uint32_t material;
    Eigen::Vector3d velocity_m_s;
  };
  void find_half_spaces(const LocalScene& scene, std::uint32_t tool_sphere,
                        const rendering::PlacedToolSphere& at,
                        const Eigen::Vector3d& goal_m) noexcept;
  [[nodiscard]] Eigen::Vector3d nearest_free_m(const Eigen::Vector3d& goal_m) noexcept;
  void add_spring(rendering::ToolForce& sum, const LocalScene& scene,
                  const Eigen::Vector3d& place_m, const rendering::PlacedToolSphere& probe,
                  const rendering::ToolPose& pose) const noexcept;

  std::array<Eigen::Vector3d, proto::kMaxToolSpheres> places_m_;
  std::array<HalfSpace, rendering::TouchedSpheres::kCapacity + proto::kMaxPlanes> half_spaces_;
  std::size_t count_ = 0;
};

}  // namespace stillgrid::laboratory
