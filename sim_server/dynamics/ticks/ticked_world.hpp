#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "shared/dynamics/engine.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/forces/trial.hpp"
#include "sim_server/dynamics/ticks/described_world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// Pose and velocity of a tool, in the frame of the world.
struct ToolPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// A world that the engine of both processes simulates.
///
/// Thread: one.
class TickedWorld {
 public:
  TickedWorld(const bodies::World& world, std::span<const scene::Hand> hands, bool may_sleep,
              EngineMethod method = {});

  /// Takes positions, velocities and gravity from the world. Pre: it has the bodies that the
  /// constructor saw.
  void read_from(const bodies::World& world);

  /// Continues from a state that the engine of another TickedWorld of the same world saved; all
  /// bodies are awake.
  void load(std::span<const std::byte> state);

  /// How a tick is taken.
  struct Tick {
    double length_s = kTick_s;
    double left_s = kTick_s;  // this tick too: tools move evenly to their poses in it
    int substeps = 0;         // 0: as many as stability asks
    std::span<const std::optional<ToolPose>> tools = {};  // hands; a tool without a pose is away
  };
  struct Report {
    int substeps = 0, touching = 0;  // contacts at the end
    EnergyFlow flow = {};
    SolveFigures solve = {};    // zero by small steps
    double sleep_loss_J = 0.0;  // kinetic energy of all that began to sleep
    bool all_slept = false;     // the world is as before
  };
  /// Advances by a tick. world is the one of the last write_to(): its prescribed bodies move as it
  /// says.
  Report advance(const bodies::World& world, const Tick& tick);

  /// Writes positions, velocities and the time to the world. Returns whether all are finite: else
  /// the world stays as it is.
  [[nodiscard]] bool write_to(bodies::World& world) const;

  /// See Engine::stop_at().
  void stop_at(const std::atomic<bool>* stop) { engine_->stop_at(stop); }

  void write_time(bodies::World& world) const { world.time_s = time_s_; }
  /// Writes who sleeps to the world. Returns whether that changed.
  bool write_sleep(bodies::World& world);
  /// Spheres that slept at the last write_sleep().
  [[nodiscard]] int sleeping_spheres() const noexcept { return sleeping_spheres_; }

  /// Shares the work of later ticks. Pre: sharing outlives this.
  void share_work(const WorkSharing& sharing) { engine_->share_work(sharing); }
  /// Measures losses from the next tick on.
  void count_losses() { engine_->count_losses(); }

  [[nodiscard]] const Engine& engine() const noexcept { return *engine_; }

 private:
  void aim(const bodies::World& world, const Tick& tick);
  void add_flow(double tick_s, EnergyFlow& flow);
  [[nodiscard]] std::size_t rigid_of_hand(std::size_t hand) const;

  std::vector<std::size_t> prescribed_;
  std::size_t hands_, first_hand_;  // first_hand_: among driven bodies
  std::vector<int> sleeper_of_body_;
  int sleeping_spheres_ = 0;
  std::unique_ptr<Engine> engine_;
  double time_s_;
  std::vector<DrivenPose> driven_;      // at the end of a tick
  bool has_end_forces_;                 // see EngineMethod
  std::vector<DrivenReaction> before_;  // forces and torques at the end of the last tick, for 1 s
};

}  // namespace stillgrid::dynamics
