#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "shared/publication/scene_segment.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/contacts/contact_memory.hpp"
#include "sim_server/dynamics/forces/implicit_stage.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/solvers/budget.hpp"
#include "sim_server/dynamics/solvers/newton.hpp"
#include "sim_server/dynamics/step/contact_response.hpp"

namespace stillgrid::dynamics {

/// Where the next step would lead, and how a change of the tool's force would bend it: one
/// implicit step from the world as it is, with the tool's contacts replaced by the force they exert
/// now, and its Jacobian. Of an explicit scene its modes tell what smaller steps do. By it a haptic
/// process leads a snapshot on for the hand where it is now, and stays on the way of the simulation
/// (docs/algorithms/predict.md).
class Prediction {
 public:
  /// is_explicit: the scene goes on in many small steps, not in one implicit one.
  explicit Prediction(bool is_explicit = false);

  /// contacts: of the world as it is, those of the hand's tool last; those of other tools are
  /// among the scene's, and these tools go on as they move. To the hand's and the nearest bodies
  /// round them the scene gives way. Three iterations at most: an impact is predicted as far as
  /// they lead. kept: what sticks, of the world's own spheres. What they do not solve moves on at
  /// its velocity and gives way there; what is not asked in a tenth of the step, or when the budget
  /// is spent, gives no way. A budget without a deadline asks no clock.
  void look(const bodies::World& world, std::span<const contact::Contact> contacts, double step_s,
            std::span<const ContactMemory> kept, Budget budget, std::size_t hand);

  [[nodiscard]] std::span<const bodies::SpherePrediction> spheres() const noexcept {
    return spheres_;
  }
  /// As World::fields; of those that do not move nothing.
  [[nodiscard]] std::span<const bodies::FieldPrediction> fields() const noexcept { return fields_; }
  /// Those of snapshot(), by the body's number in the world that was looked at: the owner's to
  /// write where the scene has another.
  [[nodiscard]] std::span<proto::TurningBody> turning() noexcept { return response_.turning(); }
  /// Counts iterations and products of the last look(), which measure its work.
  [[nodiscard]] const SolveReport& work() const noexcept { return work_; }
  /// Lasts until the next look().
  [[nodiscard]] const publication::SnapshotPrediction& snapshot() const noexcept {
    return snapshot_;
  }

 private:
  void take_contacts(const bodies::World& world, std::span<const contact::Contact> contacts,
                     std::span<const ContactMemory> kept, double step_s);
  void take_tool(const bodies::World& world, std::span<const contact::Contact> contacts);
  bool solve(ImplicitStage& stage, Eigen::VectorXd& velocity, Budget budget);
  bool solve_linear(ImplicitStage& stage, Eigen::VectorXd& velocity, const Budget& budget);
  void take_responses(const bodies::World& world, std::span<const contact::Contact> tool);
  void take_field_responses(const bodies::World& world);
  void move_fields_on(const bodies::World& world);
  void predict_fields(const bodies::World& world, double step_s);

  bool is_explicit_;
  std::vector<contact::Contact> near_;  // of the scene with itself, that may touch within the step
  std::vector<Eigen::Vector3d> stretches_m_;
  MechanicalSystem system_;
  NewtonSolver solver_;
  KrylovLinearSolver linear_solver_;
  ContactResponse response_;
  std::vector<ToolTouch> touches_;
  std::vector<bodies::SphereBinding> field_spheres_;  // that fields are to the tool
  Eigen::VectorXd residual_, tool_force_;
  std::vector<std::pair<double, std::size_t>> near_tool_;  // spheres by their distance, m
  std::vector<proto::SphereResponse> responses_;
  std::vector<bodies::SpherePrediction> spheres_;
  std::vector<bodies::FieldPrediction> fields_;
  publication::SnapshotPrediction snapshot_;
  SolveReport work_;
};

}  // namespace stillgrid::dynamics
