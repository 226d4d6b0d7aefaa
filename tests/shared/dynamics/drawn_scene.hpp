#pragma once

#include <Eigen/Geometry>

#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::dynamics {

/// A scene with balls, blocks, threads, planes and one driven body, all drawn, close to each other.
struct DrawnScene {
  EngineScene scene;
  Eigen::Vector3d tool_from_m, tool_speed_m_s, tool_spin_rad_s;

  explicit DrawnScene(std::uint64_t seed) : random_(seed) {
    scene.description.materials = {{uniform(200.0, 2000.0), uniform(0.0, 3.0), uniform(0.0, 0.8)}};
    scene.with_gravity();
    scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
    if (uniform(0.0, 1.0) < 0.5) scene.add_plane(Eigen::Vector3d(0.6, 0.0, 0.8), -0.01);
    for (int k = count(12); k > 0; --k) move(scene.add_ball(uniform(0.006, 0.012), place()));
    for (int k = count(5); k > 0; --k)
      move(scene.add_block(uniform(0.01, 0.04),
                           {uniform(0.02, 0.04), uniform(0.02, 0.04), uniform(0.02, 0.04)},
                           place()));
    for (int k = count(3); k > 0; --k) add_thread(-k);
    const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), place(), true);
    scene.add_sphere(tool, 0.008);
    scene.add_sphere(tool, 0.006, {0.012, 0.0, 0.0});
    for (std::size_t s = scene.description.spheres.size() - 2; s < scene.description.spheres.size();
         ++s)
      scene.description.spheres[s].is_tool = true;
    tool_from_m = place();
    tool_speed_m_s = 0.3 * Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    tool_spin_rad_s = 5.0 * Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    std::ranges::sort(scene.description.apart_spheres);
  }

  /// Pose of the driven body at the end of a tick. In some ticks it is away.
  [[nodiscard]] DrivenPose tool(std::uint64_t tick) const {
    const double time_s = kTick_s * static_cast<double>(tick);
    DrivenPose pose;
    pose.position_m = tool_from_m + time_s * tool_speed_m_s;
    pose.velocity_m_s = tool_speed_m_s;
    pose.orientation =
        Eigen::AngleAxisd(time_s * tool_spin_rad_s.norm(), tool_spin_rad_s.normalized());
    pose.is_here = tick % 64 >= 16;
    return pose;
  }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int count(int most) { return static_cast<int>(uniform(0.0, most + 0.999)); }
  Eigen::Vector3d place() {
    return {uniform(-0.04, 0.04), uniform(-0.04, 0.04), uniform(0.01, 0.09)};
  }
  void move(int rigid) {
    const auto r = static_cast<std::size_t>(rigid);
    scene.state.rigid_velocity_m_s[r] = {uniform(-0.3, 0.3), uniform(-0.3, 0.3), 0.0};
    scene.state.angular_velocity_rad_s[r] = {uniform(-9, 9), uniform(-9, 9), uniform(-9, 9)};
  }
  /// Eight nodes, a sphere on each and one between neighbours; these never collide.
  void add_thread(int body) {
    const Eigen::Vector3d from_m = place(), step_m(0.012, 0.004, 0.0);
    const auto first = static_cast<int>(scene.description.spheres.size());
    int before = -1;
    for (int k = 0; k < 8; ++k) {
      const int node = scene.add_node(0.003, from_m + k * step_m, k == 0);
      if (before >= 0) {
        scene.add_spring(before, node, 300.0, 0.1);
        scene.cover({before, node}, 0.007, body);
      }
      scene.cover({node}, 0.007, body);
      before = node;
    }
    const auto end = static_cast<int>(scene.description.spheres.size());
    for (int i = first; i < end; ++i)
      for (int j = i + 1; j < std::min(end, i + 5); ++j)
        scene.description.apart_spheres.emplace_back(i, j);
  }

  std::mt19937_64 random_;
};

}  // namespace stillgrid::dynamics
