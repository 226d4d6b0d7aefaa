#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/step/simulation.hpp"

namespace stillgrid::laboratory {

/// A renderer whose slow process hands over more than its snapshots hold.
class SeesSteps {
 public:
  SeesSteps() = default;
  virtual ~SeesSteps() = default;
  SeesSteps(const SeesSteps&) = delete;
  SeesSteps& operator=(const SeesSteps&) = delete;
  SeesSteps(SeesSteps&&) = delete;
  SeesSteps& operator=(SeesSteps&&) = delete;

  /// After each step, before its snapshot is shown.
  virtual void after_step(const dynamics::Simulation& simulation) = 0;
};

/// The last steps of a simulation, as far as it takes to say how their bodies give way.
class ShippedSteps {
 public:
  void take(const dynamics::Simulation& simulation);

  /// A push on a moving sphere along a unit direction.
  struct Push {
    std::size_t sphere;  // of World::spheres
    Eigen::Vector3d direction;
  };

  /// W = H C H^T: how far, m, each pushed sphere goes along its direction for a newton of each push
  /// during the step that ended at that time; C is what one implicit step over it makes of a force,
  /// springs and contacts within the scene included, those of the tool not. Zero where the step is
  /// not known, and of what is not free. Symmetric.
  [[nodiscard]] Eigen::MatrixXd compliance_m_per_N(std::uint64_t state_time_ns,
                                                   std::span<const Push> pushes) const;

 private:
  struct Step {
    double step_s = 0.0;
    bodies::World world;  // at its end
  };
  std::array<Step, 4> steps_;  // the last ones, in turn
  std::size_t taken_ = 0;
  double end_s_ = 0.0;  // of the last
};

}  // namespace stillgrid::laboratory
