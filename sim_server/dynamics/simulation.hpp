#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/detection.hpp"
#include "sim_server/dynamics/newton.hpp"
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
  int contacts = 0;                // that touch at the step's end
  std::uint64_t tool_time_ns = 0;  // of the sample it took, 0: none
  std::chrono::nanoseconds detect{}, respond{}, integrate{};
};

/// A scene's world and all that moves it on.
class Simulation {
 public:
  explicit Simulation(const SceneDescription& scene);

  /// Advances the world by step_s: in one implicit step, or where that does not converge, as when
  /// stiff contacts set in, in substeps of down to an eighth. The next step begins with half as
  /// many. If the shortest does not converge either, its iterate of least residual is taken and the
  /// report says so.
  ///
  /// The tool is asked for as late as the step allows: after the contacts among bodies were found,
  /// just before its own are [Davanne 2002, section 3].
  StepReport step(double step_s, const std::function<std::optional<ToolSample>()>& take_tool);

  [[nodiscard]] const World& world() const noexcept { return world_; }
  [[nodiscard]] World& world() noexcept { return world_; }
  [[nodiscard]] const Detection& detection() const noexcept { return detection_; }

 private:
  void place_tool(const ToolSample& sample);
  bool advance(double step_s, bool must_advance, StepReport& report);

  World world_;
  Detection detection_;
  NewtonSolver solver_;
  NewtonSolver patient_solver_{{.max_iterations = 200}};  // for the shortest substep
  std::vector<ToolSphere> tool_;                          // as described
  std::vector<ToolSphereMotion> placed_tool_;             // as last sampled; empty: no tool
  int substeps_ = 1;  // that the end of the last step took, were it all alike
};

}  // namespace stillgrid
