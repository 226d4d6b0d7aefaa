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
  /// number: of the moment to which the simulation's state belongs. period_s: of its steps.
  PathSteps(const dynamics::Simulation& simulation, std::uint64_t number, double period_s);

  /// Adds the new samples of a hand's tool to its path; null: the tool is away from now on.
  void follow(std::size_t hand, const publication::ToolView* tool);

  /// Returns how far step_until() would step.
  [[nodiscard]] double ahead_s(std::uint64_t now_ns) const;

  /// Steps as far as now_ns and the tools' newest samples, or until the budget is spent.
  dynamics::StepReport step_until(std::uint64_t now_ns, dynamics::Simulation& simulation,
                                  const dynamics::Budget& budget);

  /// Returns the moment of the state.
  [[nodiscard]] std::uint64_t time_ns() const noexcept { return number_ * proto::kPathTick_ns; }
  /// Returns the ticks that the world left out because it was too far behind.
  [[nodiscard]] std::uint64_t left_out() const noexcept { return left_out_; }
  /// Returns the state after the last step_until(), for SceneWriter::publish(). It is empty if
  /// the last tick was too long for a tick of the hand.
  [[nodiscard]] publication::SnapshotState state() const noexcept {
    if (is_too_long_) return {};
    return {.bytes = state_, .tick = number_, .hash = hash_};
  }

 private:
  struct Tool {
    dynamics::TickPath path;
    bool is_here = false;
    std::uint64_t epoch = 0;  // the segment that the path is from
  };
  [[nodiscard]] std::uint64_t newest(std::uint64_t now) const;

  std::vector<Tool> tools_;    // one a hand
  std::uint64_t longest_lag_;  // ticks
  std::uint64_t number_;
  std::uint64_t left_out_ = 0;
  std::vector<std::byte> state_;
  std::uint64_t hash_;
  bool is_too_long_ = false;
};

}  // namespace stillgrid::sim_server
