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

/// The tool's spheres over a step, moving evenly from where the last one left them to the newest
/// sample.
class ToolMotion {
 public:
  /// number: of the hand, in the scene.
  ToolMotion(scene::Hand hand, std::size_t number)
      : hand_(std::move(hand)), number_(static_cast<int>(number)) {}

  /// The tool is here at the end of this step of step_s. Without a step before it came at its
  /// velocity: so is it met alike by who moves along with it.
  void place(const ToolSample& sample, double step_s);
  /// A later sample for this step: from where the tool is when share `from` of the step is over, it
  /// moves on evenly to be there at the end. Pre: is_here(); from < 1, and not before an earlier
  /// one.
  void redirect(const ToolSample& sample, double from);
  /// There is no tool in this step.
  void remove() { over_step_.clear(); }
  [[nodiscard]] bool is_here() const noexcept { return !over_step_.empty(); }
  /// The sample of the last place() or redirect(). Pre: is_here().
  [[nodiscard]] const ToolSample& sample() const noexcept { return sample_; }

  /// Adds its spheres over the part of the step from share `start` to share `end` of it; none
  /// without a tool. Pre: start is not before a redirection.
  void add_over(double start, double end, std::vector<contact::ToolSphereMotion>& spheres) const;

 private:
  void end_at(const ToolSample& sample);

  scene::Hand hand_;
  int number_;
  ToolSample start_sample_, sample_;  // of the step before, and the newest
  double from_ = 0.0;                 // share of the step at which over_step_ begins
  std::vector<contact::ToolSphereMotion> over_step_;  // empty: no tool
  std::vector<contact::ToolSphereMotion> over_part_;
};

}  // namespace stillgrid::dynamics
