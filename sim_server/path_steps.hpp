#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/dynamics/tool_path.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/tool_segment.hpp"
#include "sim_server/dynamics/step/simulation.hpp"

namespace stillgrid::sim_server {

/// Steps a simulation along the paths that its tools took, tick by tick. Keeps the state that its
/// snapshots carry for haptic_server --transition local (docs/algorithms/local.md).
///
/// Thread: one.
class PathSteps {
 public:
  /// number: of the moment to which the simulation's state belongs.
  PathSteps(const dynamics::Simulation& simulation, std::uint64_t number);

  /// Adds the new samples of a hand's tool to its path; null: the tool is away from now on.
  void follow(std::size_t hand, const publication::ToolView* tool);
  /// Returns the number of the newest tick to which every tool that is here has come, `now` at
  /// most. Tools without a sample in the last tenth of a second do not count.
  [[nodiscard]] std::uint64_t newest(std::uint64_t now) const;

  /// Steps as far as that tick, or until the budget is spent.
  dynamics::StepReport step_to(std::uint64_t number, dynamics::Simulation& simulation,
                               const dynamics::Budget& budget);

  [[nodiscard]] std::uint64_t number() const noexcept { return number_; }
  [[nodiscard]] std::uint64_t time_ns() const noexcept { return number_ * proto::kPathTick_ns; }
  /// Returns the state after the last step_to(), for SceneWriter::publish().
  [[nodiscard]] publication::SnapshotState state() const noexcept {
    return {.bytes = state_, .tick = number_, .hash = hash_};
  }

 private:
  struct Tool {
    dynamics::TickPath path;
    bool is_here = false;
    std::uint64_t epoch = 0;  // the segment that the path is from
  };
  std::vector<Tool> tools_;  // one a hand
  std::uint64_t number_;
  std::vector<std::byte> state_;
  std::uint64_t hash_;
};

}  // namespace stillgrid::sim_server
