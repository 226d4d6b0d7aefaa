#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "shared/publication/scene_segment.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/integrators/implicit_stage.hpp"
#include "sim_server/dynamics/solvers/budget.hpp"
#include "sim_server/dynamics/solvers/linear_solver.hpp"
#include "sim_server/dynamics/solvers/newton.hpp"

namespace stillgrid::dynamics {

/// Where the next step would lead, and how a change of the tool's force would bend it: one
/// implicit step from the world as it is, with the tool's contacts replaced by the force they exert
/// now, and its Jacobian. By it a haptic process leads a snapshot on for the hand where it is
/// now, and stays on the way of the simulation (docs/algorithms/predict.md).
class Prediction {
 public:
  Prediction();

  /// contacts: of the world as it is, those of the tool last. If nothing touches the tool, the
  /// answer is to a push where, of these, it is nearest to touch. Three iterations at most: an
  /// impact is predicted as far as they lead. What is not solved in a tenth of the step,
  /// or when the budget is spent, moves on at its velocity and is not compliant; a budget without a
  /// deadline asks no clock.
  void look(const bodies::World& world, std::span<const contact::Contact> contacts, double step_s,
            Budget budget);

  [[nodiscard]] std::span<const bodies::SpherePrediction> spheres() const noexcept {
    return spheres_;
  }
  [[nodiscard]] const publication::SnapshotPrediction& snapshot() const noexcept {
    return snapshot_;
  }

 private:
  void take_contacts(const bodies::World& world, std::span<const contact::Contact> contacts,
                     double step_s);
  void take_tool(const bodies::World& world, std::span<const contact::Contact> contacts);
  bool solve(ImplicitStage& stage, Eigen::VectorXd& velocity, Budget budget);
  double push_ahead(const Eigen::Vector3d& net_N);

  /// A contact with the tool that presses.
  struct Touch {
    const bodies::SphereBinding* sphere;
    Eigen::Vector3d force_N, couple_N_m;  // on the sphere
  };

  std::vector<contact::Contact> near_;  // of the scene with itself, that may touch within the step
  MechanicalSystem system_;
  NewtonSolver solver_;
  KrylovLinearSolver linear_solver_;
  std::vector<Touch> touches_;
  Eigen::VectorXd tool_force_, tool_push_;  // as it is; per newton along its direction
  std::vector<bodies::SpherePrediction> spheres_;
  publication::SnapshotPrediction snapshot_;
};

}  // namespace stillgrid::dynamics
