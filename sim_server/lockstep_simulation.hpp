#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/publication/scene_segment.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/lockstep_schedule.hpp"
#include "sim_server/path_steps.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// The clock that costs are taken by, s.
using CostClock = std::function<double()>;

/// sim_server's lockstep without a peer to wait for: the caller knows what time it is. Publishes
/// into a session of its own.
///
/// Thread: one, several objects at a time. Not real-time.
class LockstepSimulation {
 public:
  using AfterStep = std::function<void(dynamics::Simulation&, const dynamics::StepReport&)>;
  /// Told of each snapshot as it is shown, but the one of time zero.
  using AfterPublication =
      std::function<void(const dynamics::Simulation&, const publication::SnapshotTimes&)>;

  /// world: build_world(scene), moved. now_s: by which steps are measured; empty: they are not.
  /// contacts: of Simulation::contact_state(), or empty.
  /// Throws SegmentError.
  LockstepSimulation(const scene::SceneDescription& scene, bodies::World world,
                     LockstepSchedule schedule, CostClock now_s = {},
                     std::span<const std::byte> contacts = {});

  /// Steps of a scene whose static_scene() has a model keep to that tool's path, and snapshots have
  /// the state. Pre: before run_to(); the view outlives this.
  void follow(const publication::ToolView& tool) noexcept { tool_ = &tool; }

  /// Takes the tool for each step that is due before now_ns, or with `at_now` also at that time,
  /// and shows each snapshot that is due by then. Throws std::domain_error as Simulation::step().
  void run_to(std::uint64_t now_ns, bool at_now, const dynamics::TakeTool& take_tool,
              const AfterStep& after_step = {}, const AfterPublication& after_publication = {});

  [[nodiscard]] const std::string& session() const noexcept { return session_; }
  /// Returns a view of the published scene. Throws SegmentError.
  [[nodiscard]] publication::SceneView view() const;
  [[nodiscard]] dynamics::Simulation& simulation() noexcept { return simulation_; }
  /// When the tool is taken: for the step being computed, or the next.
  [[nodiscard]] std::uint64_t sample_ns() const noexcept { return snapshot_.sample_ns; }
  /// Returns the time of each step with its snapshot, if measured.
  [[nodiscard]] const std::vector<double>& step_s() const noexcept { return step_s_; }

 private:
  void step(const dynamics::TakeTool& take_tool, const AfterStep& after_step);
  [[nodiscard]] dynamics::StepReport step_to_state(const dynamics::TakeTool& tool);
  [[nodiscard]] bool is_followed() const noexcept { return paths_ && tool_ != nullptr; }
  [[nodiscard]] publication::SnapshotState state() const {
    return is_followed() ? paths_->state() : publication::SnapshotState();
  }
  [[nodiscard]] double now_s() const { return clock_s_ ? clock_s_() : 0.0; }

  std::string session_;
  CostClock clock_s_;
  dynamics::Simulation simulation_;
  std::optional<PathSteps> paths_;               // there if static_scene() has a model
  const publication::ToolView* tool_ = nullptr;  // to follow
  publication::SceneWriter writer_;
  LockstepSchedule schedule_;
  ScheduledSnapshot snapshot_;                       // the next, or computed and not yet shown
  std::optional<publication::SnapshotTimes> times_;  // of a snapshot that is computed
  std::vector<double> step_s_;
};

}  // namespace stillgrid::sim_server
