#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/block_matrix.hpp"
#include "sim_server/dynamics/integrator.hpp"
#include "sim_server/dynamics/nonlinear_solver.hpp"

namespace stillgrid {

/// Everything of a world that is free to move, as one system of momentum and force,
///   d (M(q) u) / dt = f(t, q, u),
/// with velocities u (m/s; rad/s) in blocks of three, numbered as in World: three a node, six a
/// rigid body, linear then angular. Configurations q are given as displacements from the world's
/// own: metres, and rotation vectors (rad, world frame) of rigid bodies.
///
/// The definite slope leaves out what has no potential or a falling one: gyroscopic terms, the
/// sideways push of compressed springs and of contacts, the turning of levers, friction's change
/// with pressure.
class MechanicalSystem {
 public:
  /// Pre: world and contacts outlive it and do not change.
  MechanicalSystem(const World& world, std::span<const Contact> contacts);

  [[nodiscard]] Eigen::Index size() const { return world_.unknown_count; }

  /// Masses, and for rotations the largest principal moment of inertia (kg; kg m2).
  [[nodiscard]] const Eigen::VectorXd& mass_diagonal() const { return mass_; }

  /// Factors that turn momenta into velocities in one unit (m/s): 1 / mass, and for rotations the
  /// body's reach over its inertia.
  [[nodiscard]] const Eigen::VectorXd& momentum_scale() const { return scale_; }

  /// The world's velocities.
  [[nodiscard]] Eigen::VectorXd velocity() const;

  /// Places all that is free `displacement` from where the world has it, with velocities u;
  /// prescribed bodies where they are time_s later.
  void place(const Eigen::VectorXd& displacement, const Eigen::VectorXd& u, double time_s);

  /// M(q) u where all was placed last.
  void momentum(Eigen::VectorXd& momentum) const;

  /// Forces and torques where all was placed last: gravity, springs, contacts. contact_step_s: the
  /// time since the contacts' depth_before_m, over which their dampers act.
  void force(double contact_step_s, Eigen::VectorXd& force);

  /// d(momentum - stage_s * force) / du where all was placed last, if displacement and velocity
  /// change by stage_s and 1 a unit of u: the slope of an implicit stage.
  void jacobian(Slope slope, double stage_s, Eigen::SparseMatrix<double>& matrix);

  /// The same as an operator: takes the slope here, for multiply() and block_diagonal().
  void linearise(Slope slope, double stage_s);
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  [[nodiscard]] const Eigen::Matrix3Xd& block_diagonal() const { return diagonal_; }

  /// Everything where it was placed last.
  [[nodiscard]] const Trial& trial() const noexcept { return trial_; }

 private:
  void add_springs(Eigen::VectorXd& force) const;
  void add_contacts(double contact_step_s, Eigen::VectorXd& force);
  void add_inertia_slopes(Slope slope, double stage_s);
  void add_spring_slopes(Slope slope, double stage_s);
  void add_contact_slopes(Slope slope, double stage_s);
  void push_sphere(const SphereBinding& sphere, const Eigen::Vector3d& force_N,
                   const Eigen::Vector3d& couple_N_m, Eigen::VectorXd& force) const;

  const World& world_;
  std::span<const Contact> contacts_;
  Eigen::VectorXd mass_, scale_;
  Trial trial_;
  BlockMatrix blocks_;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::Matrix3Xd diagonal_;
};

}  // namespace stillgrid
