#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/contact/field_touch.hpp"
#include "sim_server/dynamics/forces/contact_jacobian.hpp"
#include "sim_server/dynamics/forces/joint_jacobian.hpp"
#include "sim_server/dynamics/forces/spring_jacobian.hpp"
#include "sim_server/dynamics/forces/trial.hpp"
#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// Where on its way through a step the lever is taken by which a contact presses on a body, and
/// the normal along which.
enum class Levers {
  kAtEnd,
  kMean,  // over the way: the pressure's work is what its spring lost, however far they turn
};

/// Everything of a world that is free to move, as one system of momentum and force,
///   d (M(q) u) / dt = f(t, q, u),
/// with velocities u (m/s; rad/s) in blocks of three, numbered as in World: three a node, six a
/// rigid body, linear then angular. Configurations q are given as displacements from the world's
/// own: metres, and rotation vectors (rad, world frame) of rigid bodies.
///
/// Its Jacobian is what masses, springs, joints and contacts each resist, and by that an operator;
/// the matrix is their sum. The symmetric Jacobian leaves out gyroscopic terms, the turning of
/// levers and of dampers, friction's change with pressure and place; the definite one also the
/// sideways push of compressed springs and of contacts. What sleeps costs nothing.
class MechanicalSystem {
 public:
  MechanicalSystem() = default;
  MechanicalSystem(const bodies::World& world, std::span<const contact::Contact> contacts) {
    take(world, contacts);
  }

  /// From now on this world with these contacts; memory is kept. stretches_m: of each contact, what
  /// sticking friction begins with; none at all: friction is viscous. Pre: all stay as they are
  /// while it is used.
  void take(const bodies::World& world, std::span<const contact::Contact> contacts,
            std::span<const Eigen::Vector3d> stretches_m = {}, Levers levers = Levers::kAtEnd);

  [[nodiscard]] Eigen::Index size() const { return mass_.size(); }

  /// Masses, and for rotations the largest principal moment of inertia (kg; kg m2).
  [[nodiscard]] const Eigen::VectorXd& mass_diagonal() const { return mass_; }

  /// Factors that turn momenta into velocities in one unit (m/s): 1 / mass, and for rotations the
  /// body's reach over its inertia.
  [[nodiscard]] const Eigen::VectorXd& momentum_scale() const { return scale_; }

  /// The world's velocities.
  [[nodiscard]] Eigen::VectorXd velocity() const;

  /// Places all that is awake `displacement` from where the world has it, with velocities u;
  /// prescribed bodies where they are time_s later, and given spheres, as the tool's, where the
  /// contacts have them. What sticks has slid for time_s.
  void place(const Eigen::VectorXd& displacement, const Eigen::VectorXd& u, double time_s);

  /// M(q) u where all was placed last. Pre: not the same.
  void momentum(const Eigen::VectorXd& u, Eigen::VectorXd& momentum) const;

  /// Forces and torques where all was placed last: gravity, springs, joints, contacts.
  /// contact_step_s: the time since the contacts' depth_before_m, over which their dampers act.
  void force(double contact_step_s, Eigen::VectorXd& force);

  /// d(momentum - stage_s * force) / du where all was placed last, if displacement and velocity
  /// change by stage_s and 1 a unit of u: computes the Jacobian of an implicit stage as an
  /// operator, for multiply() and block_diagonal(). Contacts' dampers act over stage_s, which is
  /// not zero.
  void linearise(JacobianKind kind, double stage_s);
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  [[nodiscard]] const Eigen::Matrix3Xd& block_diagonal() const { return diagonal_; }
  /// Masses and springs of it, where it was not exact; joints and contacts are the rest.
  [[nodiscard]] BlockTriangle& triangle() { return triangle_; }
  void add_rest(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  [[nodiscard]] bool has_rest() const {
    return !contact_jacobians_.empty() || !joint_jacobians_.empty();
  }

  /// Adds to `force` one at a sphere's centre, and a couple that only a rigid body can take up,
  /// where all was placed last.
  void push_sphere(const bodies::SphereBinding& sphere, const Eigen::Vector3d& force_N,
                   const Eigen::Vector3d& couple_N_m, Eigen::VectorXd& force) const;

  /// How a sphere's centre moves where all was placed last, were velocities u: what push_sphere()
  /// is the transpose of. Zero of what does not move.
  [[nodiscard]] Eigen::Vector3d velocity_of(const bodies::SphereBinding& sphere,
                                            const Eigen::VectorXd& u) const;

  /// Everything where it was placed last.
  [[nodiscard]] const Trial& trial() const noexcept { return trial_; }

 private:
  void add_contact_forces(double contact_step_s, Eigen::VectorXd& force);
  void add_spring_jacobians(JacobianKind kind);
  void take_joints();
  [[nodiscard]] JointSide joint_side(const bodies::JointEnd& end) const;
  void add_joint_forces(Eigen::VectorXd& force) const;
  void add_joint_jacobians(JacobianKind kind);
  void find_links();
  void fill_triangle(JacobianKind kind);
  void add_inertia_jacobians(JacobianKind kind);
  void add_contact_jacobians(JacobianKind kind);
  void find_touching();

  /// A contact with a side awake, as little of it as tells whether it touches.
  struct Candidate {
    int contact, a, b;
    double bounding_radius_m;                             // of both spheres
    Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // as the step begins, of what sticks
    std::optional<Eigen::Vector3d> start_m = {};  // likewise, of spheres that overlap: a from b
    int touch = -1;                               // of a field's: in touches_
  };
  /// A field's side of a contact, where all was placed last.
  struct Touch {
    const bodies::FieldBody* field;
    int other;        // the sphere that it meets, or -1: what is given in the contact
    double radius_m;  // of that
    const contact::Contact* contact;
    contact::FieldTouch at = {};
    bodies::SphereBinding binding = {};
    bodies::SphereMotion motion = {};
  };
  void add_touch(Candidate& candidate);
  void place(Touch& touch) const;
  /// The contact, as stiff as it is where a field is met. own: room for it.
  const contact::Contact& contact_at(const Candidate& candidate, contact::Contact& own) const;
  [[nodiscard]] const bodies::SphereBinding& binding_of(const Candidate& candidate,
                                                        int number) const;
  [[nodiscard]] contact::ContactMotion motion_of(const Candidate& candidate) const;
  [[nodiscard]] contact::SideMotion side_of(const Candidate& candidate, int number,
                                            bool sticks) const;
  [[nodiscard]] Eigen::Vector3d press_arm_m(const bodies::SphereBinding& sphere) const;
  /// d(momentum) / du of a block of three.
  struct InertiaJacobian {
    int unknown;
    Eigen::Matrix3d block;
  };

  const bodies::World* world_ = nullptr;
  std::span<const contact::Contact> contacts_;
  std::vector<Candidate> candidates_;
  std::vector<Touch> touches_;
  std::vector<int> touching_;  // or nearly so: candidates, where all was placed last
  bool sticks_ = false;
  std::vector<std::span<const bodies::Spring>> springs_;  // of bodies awake
  std::vector<const bodies::Joint*> joints_;              // of them with an end that moves
  Eigen::VectorXd mass_, scale_;
  Trial trial_;
  std::vector<Eigen::Vector3d> turned_rad_;  // of each rigid body, from the world's orientation
  Levers levers_ = Levers::kAtEnd;
  std::vector<Eigen::Matrix3d>
      mean_turns_;  // of each: what makes the mean arm of its end's, less 1
  double time_s_ = 0.0;

  // The Jacobian taken last.
  double stage_s_ = 0.0;
  std::vector<InertiaJacobian> inertia_jacobians_;
  std::vector<SpringJacobian> spring_jacobians_;
  std::vector<JointJacobian> joint_jacobians_;
  std::vector<ContactJacobian> contact_jacobians_;
  std::vector<Eigen::Matrix3d> turn_s_;  // of each rigid body: d(turned, world frame) / d spin
  Eigen::Matrix3Xd diagonal_;
  bool is_exact_ = false;
  std::vector<BlockTriangle::Link> links_;  // of springs_, those between two that move
  BlockTriangle triangle_;
};

}  // namespace stillgrid::dynamics
