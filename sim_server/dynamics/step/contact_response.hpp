#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "proto/scene_segment.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/forces/implicit_stage.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/solvers/budget.hpp"
#include "sim_server/dynamics/solvers/linear_solver.hpp"

namespace stillgrid::dynamics {

/// A contact of the tool with something that moves.
struct ToolTouch {
  const bodies::SphereBinding* sphere;
  double depth_m;                       // negative: a gap
  Eigen::Vector3d force_N, couple_N_m;  // on the sphere; zero without overlap
};

/// How an implicit step gives way to the tool: the step's own equations, reduced to what the tool
/// may push (Galerkin).
///
/// With A the Jacobian of a step of P, in momentum, forces f displace all by P^2 A^-1 f. The step's
/// answers Z to pushes on each touched body, in three directions and, of a rigid one, about three
/// axes, span a space; in it are modes B, of which
///   B^T A B = P^2 1,   B^T M B = P^2 diag(inertia_share),
/// so that forces displace all by B B^T f there. That is symmetric and positive semidefinite
/// whatever Z is, gives way nowhere more than the step itself, and is the step's own answer to what
/// was pushed (docs/algorithms/predict.md). Thread: one.
class ContactResponse {
 public:
  /// system: placed where the step is linear, as where it leads at velocity; stage is of step_s. A
  /// push that is not solved in the budget is left out.
  void find(const bodies::World& world, const MechanicalSystem& system, ImplicitStage& stage,
            double step_s, std::span<const ToolTouch> touches, const Eigen::VectorXd& velocity,
            const Budget& budget);
  /// Tells damping and stiffness of each mode apart: it gives way by steps.
  /// Pre: system as in find().
  void find_damping(MechanicalSystem& system, double step_s);
  /// Nothing gives way.
  void clear() {
    modes_.clear();
    turning_.clear();
  }

  [[nodiscard]] std::span<const proto::ResponseMode> modes() const noexcept { return modes_; }
  /// Counts products with the Jacobian in all calls of find().
  [[nodiscard]] long products() const noexcept { return solver_.products(); }
  /// Rigid bodies that are touched.
  [[nodiscard]] std::span<const proto::TurningBody> turning() const noexcept { return turning_; }
  [[nodiscard]] std::span<proto::TurningBody> turning() noexcept { return turning_; }
  /// How the sphere's centre moves in each mode. Pre: the system is placed as in find().
  [[nodiscard]] proto::SphereResponse response_of(const MechanicalSystem& system,
                                                  const bodies::SphereBinding& sphere) const;
  /// How a body turns in each mode, rad / sqrt(J). Pre: it feels forces.
  [[nodiscard]] proto::SphereResponse turning_of(const bodies::RigidBody& body) const;

 private:
  /// Touches of one body: a range of those in order.
  struct Group {
    std::size_t first, last;
    double depth_m, weight_m;
  };
  void group(std::span<const ToolTouch> touches);
  void find_pushes(const MechanicalSystem& system);
  struct Answer {
    Eigen::VectorXd motion, resisted;  // A times it
  };
  Eigen::VectorXd& add_push(const MechanicalSystem& system);
  void push_together(const MechanicalSystem& system, const Group& group);
  void answer_pushes(ImplicitStage& stage, const Budget& budget);
  void find_modes(const MechanicalSystem& system, const ImplicitStage& stage, double step_s,
                  const Eigen::VectorXd& velocity);
  void find_turning(const bodies::World& world, const MechanicalSystem& system, double step_s);

  KrylovLinearSolver solver_;
  std::vector<ToolTouch> touches_;  // by body, the deepest first
  std::vector<Group> groups_;       // the deepest first
  // As many as counted, and memory of those before.
  std::vector<Eigen::VectorXd> pushes_;
  std::size_t push_count_ = 0;
  std::vector<Answer> answers_;
  std::size_t answer_count_ = 0;
  Eigen::VectorXd tool_force_, momentum_;
  std::vector<Eigen::VectorXd> motions_;  // of each mode
  std::vector<proto::ResponseMode> modes_;
  std::vector<proto::TurningBody> turning_;
};

}  // namespace stillgrid::dynamics
