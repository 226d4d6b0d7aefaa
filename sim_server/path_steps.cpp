#include "sim_server/path_steps.hpp"

#include <algorithm>
#include <optional>

namespace stillgrid::sim_server {
namespace {

/// A tool that is still for so many ticks keeps nobody waiting.
constexpr std::uint64_t kPatience = 100;
/// A world that is so many ticks behind leaves them out: hands show no older state than a second.
/// Two periods are none behind, as far as paths reach back.
std::uint64_t longest_lag(double period_s) {
  constexpr double kLag = 900.0, kPath = 3500.0;
  return static_cast<std::uint64_t>(std::clamp(2.0 * period_s / dynamics::kTick_s, kLag, kPath));
}

}  // namespace

PathSteps::PathSteps(const dynamics::Simulation& simulation, std::uint64_t number, double period_s)
    : tools_(simulation.hands()),
      longest_lag_(longest_lag(period_s)),
      number_(number),
      hash_(simulation.save_state(state_)) {}

void PathSteps::follow(std::size_t hand, const publication::ToolView* tool) {
  Tool& followed = tools_[hand];
  followed.is_here = tool != nullptr;
  if (tool == nullptr) return;
  if (followed.epoch != tool->header().epoch) followed.path = {};
  followed.epoch = tool->header().epoch;
  dynamics::follow(tool->path(), followed.path);
}

/// Returns the number of the newest tick to which every tool that is here has come, `now` at most.
/// Tools without a sample in the last tenth of a second do not count.
std::uint64_t PathSteps::newest(std::uint64_t now) const {
  std::uint64_t newest = now;
  for (const Tool& tool : tools_) {
    const auto of_tool = tool.path.newest();
    if (tool.is_here && of_tool && *of_tool + kPatience > now) newest = std::min(newest, *of_tool);
  }
  return newest;
}

double PathSteps::ahead_s(std::uint64_t now_ns) const {
  const std::uint64_t number = newest(now_ns / proto::kPathTick_ns);
  return static_cast<double>(number - std::min(number, number_)) * dynamics::kTick_s;
}

dynamics::StepReport PathSteps::step_until(std::uint64_t now_ns, dynamics::Simulation& simulation,
                                           const dynamics::Budget& budget) {
  const std::uint64_t number = newest(now_ns / proto::kPathTick_ns);
  bool was_left_out = false;
  if (number > number_ + longest_lag_) {
    left_out_ += number - 1 - number_;
    number_ = number - 1;
    was_left_out = true;  // tools come anew, for they moved too far for a tick
  }
  if (number <= number_) return {.solve = {.converged = true}};
  std::vector<dynamics::TakeTool> samples;
  std::vector<dynamics::ToolAt> poses;
  for (const Tool& tool : tools_) {
    samples.emplace_back([&tool, number]() -> std::optional<dynamics::ToolSample> {
      const auto pose = tool.path.pose_at(number);
      if (!pose) return std::nullopt;
      return dynamics::ToolSample{number * proto::kPathTick_ns, pose->position_m, pose->orientation,
                                  pose->velocity_m_s};
    });
    poses.emplace_back(
        [&tool, was_left_out](std::uint64_t at) -> std::optional<dynamics::ToolPose> {
          if (was_left_out) return std::nullopt;
          return tool.path.pose_at(at);
        });
  }
  const double step_s = static_cast<double>(number - number_) * dynamics::kTick_s;
  const dynamics::StepReport report =
      simulation.step(step_s, samples, budget, {.number = number_, .tools = poses});
  number_ += static_cast<std::uint64_t>(report.ticks);
  hash_ = simulation.save_state(state_);
  is_too_long_ = report.last_counted_ns > dynamics::kLongestTickWithContacts_ns;
  return report;
}

}  // namespace stillgrid::sim_server
