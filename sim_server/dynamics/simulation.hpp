#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/detection.hpp"
#include "sim_server/dynamics/budget.hpp"
#include "sim_server/dynamics/integrator.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid {

/// The tool as the simulation takes it: one sample of its pose and velocity.
struct ToolSample {
  std::uint64_t time_ns = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// What one step did and what each of its phases cost.
struct StepReport {
  SolveReport solve;  // iterations of all substeps, the worst residual
  int substeps = 0;
  bool out_of_budget = false;      // so that its end was computed by one iteration
  int crossings_left = 0;          // substeps in which spheres may have passed through one another
  int contacts = 0;                // that touch at the step's end
  std::uint64_t tool_time_ns = 0;  // of the sample it took, 0: none
  std::chrono::nanoseconds detect{}, respond{}, integrate{};
};

/// The longest part of a step, halved until it is shorter than one of `length` by more than the
/// rounding of its ends: parts that begin where spheres would have crossed have any length.
[[nodiscard]] inline double halved_below(double longest, double length) noexcept {
  while (longest > 0.75 * length) longest /= 2.0;
  return longest;
}

/// A scene's world and all that moves it on.
class Simulation {
 public:
  explicit Simulation(const SceneDescription& scene);

  /// Advances the world by step_s: in one implicit step, or where that does not converge, as when
  /// stiff contacts set in, in substeps of down to an eighth. The next step begins with half as
  /// many. If the shortest does not converge either, its iterate of least residual is taken and the
  /// report says so.
  ///
  /// A substep also ends where spheres would pass each other unseen, or come too deep at once: so
  /// nothing, the tool on its straight path since its last sample included, crosses a body however
  /// fast it moves (docs/algorithms/fast_bodies.md). A step is shortened so 64 times at most; the
  /// report counts what that left.
  ///
  /// A step whose budget is spent goes to its end at once, in one part of one iteration: bodies
  /// move on safely if not exactly, and the image comes in time. The report says so.
  ///
  /// The tool is asked for as late as the step allows: after the contacts among bodies were found,
  /// just before its own are [Davanne 2002, section 3].
  StepReport step(double step_s, const std::function<std::optional<ToolSample>()>& take_tool,
                  Budget budget = {});

  [[nodiscard]] const World& world() const noexcept { return world_; }
  [[nodiscard]] World& world() noexcept { return world_; }
  [[nodiscard]] const Detection& detection() const noexcept { return detection_; }

 private:
  /// A part of a step, as shares of it, and what limits it.
  struct Part {
    double start = 0.0, end = 1.0;
    bool must_advance = false;  // though the solver did not converge
    bool may_shorten = true;    // to keep spheres from crossing
    bool must_end = false;      // the step: its budget is spent
  };
  /// What came of an attempt: done, or how much of it to try.
  struct Attempt {
    bool advanced = false;
    double share = 1.0;  // less than 1: spheres would cross beyond it
  };

  void place_tool(const ToolSample& sample);
  void find_tool_contacts(const Part& part);
  Attempt advance(const Part& part, double step_s, Budget& budget, StepReport& report);
  double share_by_velocity(double duration_s);

  World world_;
  Detection detection_;
  Method method_;
  std::unique_ptr<Integrator> integrator_;
  std::vector<ToolSphere> tool_;  // as described
  ToolSample last_sample_;
  std::vector<ToolSphereMotion> placed_tool_;  // over the step; empty: no tool
  std::vector<ToolSphereMotion> tool_part_;    // over a part of it
  std::vector<SphereMotion> start_, end_;      // of every sphere over a part
  int substeps_ = 1;  // that the end of the last step took, were it all alike
};

}  // namespace stillgrid
