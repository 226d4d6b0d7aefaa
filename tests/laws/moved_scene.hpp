#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/laws/law_case.hpp"

namespace stillgrid::laws {

/// Where the tool is; none: nobody is there.
using ToolPath = std::function<std::optional<dynamics::ToolSample>(double time_s)>;

/// Of each hand of the scene, in its order.
using ToolPaths = std::vector<ToolPath>;

/// The hands of the case, of formulas.
[[nodiscard]] ToolPaths tool_paths_of(const LawCase& law_case);

/// Called after each step with the time at its end. False: enough.
using AfterStep =
    std::function<bool(dynamics::Simulation&, const dynamics::StepReport&, double time_s)>;

/// Takes the scene through the case's steps, jittered as lockstep draws them, without a haptic
/// side: until its duration is over, three steps at least. Each takes the tools where they are at
/// its end, as lockstep without cost does.
void move_scene(const scene::SceneDescription& scene, const LawCase& law_case,
                const ToolPaths& paths, const AfterStep& after);

/// Centres of all bodies but planes and what is static, in the order of the scene.
[[nodiscard]] std::vector<Eigen::Vector3d> centres_m(const bodies::World& world);
/// Of the same worlds; infinite where either is no number.
[[nodiscard]] double farthest_m(const std::vector<Eigen::Vector3d>& a,
                                const std::vector<Eigen::Vector3d>& b);

/// How far a relative change by 1e-13 of all masses leads the centres apart: what rounding alone
/// may make of the case.
[[nodiscard]] double rounding_m(const scene::SceneDescription& scene, const LawCase& law_case,
                                const ToolPaths& paths);

/// Where the case's scene leads.
[[nodiscard]] std::vector<Eigen::Vector3d> end_of(const scene::SceneDescription& scene,
                                                  const LawCase& law_case, const ToolPaths& paths);

}  // namespace stillgrid::laws
