#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <utility>
#include <vector>

#include "sim_server/contact/detection.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// The tool as the simulation takes it: one sample of its pose and velocity.
struct ToolSample {
  std::uint64_t time_ns = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// The tool as the last steps took it.
class ToolMotion {
 public:
  /// number: of the hand, in the scene.
  ToolMotion(scene::Hand hand, std::size_t number)
      : hand_(std::move(hand)), number_(static_cast<int>(number)) {}

  /// The tool is here at the end of this step.
  void place(const ToolSample& sample);
  /// A later sample for this step. Pre: is_here().
  void redirect(const ToolSample& sample) { sample_ = sample; }
  /// There is no tool in this step.
  void remove() { is_here_ = false; }
  [[nodiscard]] bool is_here() const noexcept { return is_here_; }
  /// The sample of the last place() or redirect(). Pre: is_here().
  [[nodiscard]] const ToolSample& sample() const noexcept { return sample_; }

  /// Adds its spheres at the end of the step. They turn as from the step before. None without a
  /// tool.
  void add_spheres(std::vector<contact::ToolSphereMotion>& spheres) const;

 private:
  scene::Hand hand_;
  int number_;
  bool is_here_ = false;
  ToolSample before_, sample_;  // of the step before, and the newest
};

}  // namespace stillgrid::dynamics
