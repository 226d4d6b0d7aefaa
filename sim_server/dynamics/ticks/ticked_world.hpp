#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "proto/tool_segment.hpp"
#include "shared/dynamics/engine.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/ticks/described_world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// Pose and velocity of a tool at the end of a step, in the frame of the world.
struct ToolPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// A world that the engine of both processes simulates, in ticks of 1 ms or a little less.
///
/// Thread: one.
class TickedWorld {
 public:
  TickedWorld(const bodies::World& world, std::span<const scene::Hand> hands);

  /// Figures of a step.
  struct Report {
    int substeps = 0;                               // sum over ticks
    int touching = 0;                               // contacts at the end
    std::array<double, proto::kMaxHands> work_J{};  // that each hand's tool gave
    double to_driven_J = 0.0;                       // of it to prescribed and static bodies
    double prescribed_work_J = 0.0;                 // that prescribed bodies gave it by contacts
    EnergyLosses losses;                            // zero without count_losses()
  };
  /// Advances the world by step_s, tools by hand: each moves evenly to its pose. Writes positions,
  /// velocities and the time to the world.
  Report step(bodies::World& world, double step_s, std::span<const std::optional<ToolPose>> tools);

  /// Measures losses from the next step on.
  void count_losses() { engine_->count_losses(); }

  [[nodiscard]] const Engine& engine() const noexcept { return *engine_; }

 private:
  void aim(const bodies::World& world, double time_s, double share,
           std::span<const std::optional<ToolPose>> tools);
  void add_work(Report& report) const;
  void write_to(bodies::World& world) const;

  std::vector<std::size_t> prescribed_;
  std::size_t first_hand_;  // among driven bodies
  std::unique_ptr<Engine> engine_;
  std::vector<DrivenPose> driven_;               // at the end of a tick
  std::vector<std::optional<ToolPose>> before_;  // hands at the end of the last step
};

}  // namespace stillgrid::dynamics
