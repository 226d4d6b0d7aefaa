#pragma once

#include <atomic>
#include <span>
#include <vector>

#include "shared/dynamics/scene_ticks.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/ticks/described_world.hpp"
#include "sim_server/dynamics/ticks/energy_flow.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// A world that the engine of both processes simulates.
///
/// Thread: one.
class TickedWorld {
 public:
  TickedWorld(const bodies::World& world, std::span<const scene::Hand> hands, bool may_sleep,
              EngineMethod method = {})
      : TickedWorld(described(world, hands, may_sleep), world, method) {}

  /// Takes positions, velocities and gravity from the world. Pre: it has the bodies that the
  /// constructor saw.
  void read_from(const bodies::World& world);

  /// Continues from a state that the engine of another TickedWorld of the same world saved; all
  /// bodies are awake.
  void load(std::span<const std::byte> state);

  using Tick = SceneTicks::Tick;
  struct Report {
    int substeps = 0, touching = 0;  // contacts at the end
    EnergyFlow flow = {};
    SolveFigures solve = {};    // zero by small steps
    double sleep_loss_J = 0.0;  // kinetic energy of all that began to sleep
    bool all_slept = false;     // the world is as before
    double counted_ns = 0.0;    // see SceneTicks
  };
  /// Advances by a tick.
  Report advance(const Tick& tick);

  /// Writes positions, velocities and the time to the world. Returns whether all are finite: else
  /// the world stays as it is.
  [[nodiscard]] bool write_to(bodies::World& world) const;

  /// See Engine::stop_at().
  void stop_at(const std::atomic<bool>* stop) { ticks_.engine().stop_at(stop); }

  void write_time(bodies::World& world) const { world.time_s = ticks_.time_s(); }
  /// Writes who sleeps to the world. Returns whether that changed.
  bool write_sleep(bodies::World& world);
  /// Spheres that slept at the last write_sleep().
  [[nodiscard]] int sleeping_spheres() const noexcept { return sleeping_spheres_; }

  /// Shares the work of later ticks. Pre: sharing outlives this.
  void share_work(const WorkSharing& sharing) { ticks_.engine().share_work(sharing); }
  /// Measures losses from the next tick on.
  void count_losses() { ticks_.engine().count_losses(); }

  /// Writes the state from which a SceneTicks of the same world continues to the bit.
  void save(std::vector<std::byte>& block) const { ticks_.save(block); }
  [[nodiscard]] const Engine& engine() const noexcept { return ticks_.engine(); }
  [[nodiscard]] const SceneTicks& ticks() const noexcept { return ticks_; }

 private:
  TickedWorld(DescribedWorld from, const bodies::World& world, EngineMethod method);
  void add_flow(double tick_s, EnergyFlow& flow);

  std::vector<std::size_t> prescribed_;
  std::vector<int> sleeper_of_body_;
  int sleeping_spheres_ = 0;
  SceneTicks ticks_;
  bool has_end_forces_;                 // see EngineMethod
  std::vector<DrivenReaction> before_;  // forces and torques at the end of the last tick, for 1 s
};

}  // namespace stillgrid::dynamics
