#include "shared/rendering/placed_tool.hpp"

namespace stillgrid::rendering {

std::span<PlacedToolSphere> place_tool(const proto::SceneHeader& scene, const ToolPose& pose,
                                       ToolSpheres& placed) noexcept {
  for (std::uint32_t i = 0; i < scene.tool_sphere_count; ++i) {
    const auto& p = scene.tool[i].position_m;
    const Eigen::Vector3d position_m =
        pose.position_m + pose.orientation * Eigen::Vector3d(p[0], p[1], p[2]);
    placed[i] = {position_m, static_cast<double>(scene.tool[i].radius_m)};
  }
  return {placed.data(), scene.tool_sphere_count};
}

}  // namespace stillgrid::rendering
