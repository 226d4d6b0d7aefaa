#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/block_matrix.hpp"
#include "sim_server/dynamics/nonlinear_solver.hpp"

namespace stillgrid {

/// One implicit Euler step of the whole coupled world: springs, rigid bodies, contacts.
///
/// Unknowns u are the velocities at the step's end (m/s, rad/s); the residual is
///   M (v1 - v0) - h f(x0 + h v1, v1)            for nodes and centres of mass,
///   I(R1) w1 - I(R0) w0 - h torque, R1 = exp(h w1) R0   for rotations: the gyroscopic term is in
///   it.
/// The definite slope leaves out what has no potential or a falling one: gyroscopic terms, the
/// sideways push of compressed springs and of contacts, the turning of levers, friction's change
/// with pressure. Source: implicit Euler as in [Davanne 2002, section 5], in velocities.
class ImplicitEulerStep : public NonlinearSystem {
 public:
  /// Pre: world and contacts outlive the step and do not change. step_s > 0.
  ImplicitEulerStep(const World& world, std::span<const Contact> contacts, double step_s);

  [[nodiscard]] Eigen::Index size() const override { return world_.unknown_count; }
  void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) override;
  void jacobian(Slope slope, Eigen::SparseMatrix<double>& matrix) override;
  [[nodiscard]] const Eigen::VectorXd& residual_scale() const override { return scale_; }

  /// The velocities at the step's start: a first guess.
  [[nodiscard]] Eigen::VectorXd initial_guess() const;

  /// Moves the world to the state of u. Pre: u is the argument of the last residual().
  void commit(World& world) const;

  /// Every sphere of the world at the last u.
  [[nodiscard]] std::span<const SphereMotion> motion() const noexcept { return motion_; }

  /// Contacts that touch at the last u.
  [[nodiscard]] int touching() const noexcept { return touching_; }

 private:
  void set_state(const Eigen::VectorXd& u);
  void add_inertia(Eigen::VectorXd& residual) const;
  void add_springs(Eigen::VectorXd& residual) const;
  void add_contacts(Eigen::VectorXd& residual);
  void add_inertia_slopes(Slope slope);
  void add_spring_slopes(Slope slope);
  void add_contact_slopes(Slope slope);
  void push_sphere(const SphereBinding& sphere, const Eigen::Vector3d& impulse_N_s,
                   const Eigen::Vector3d& couple_N_m_s, Eigen::VectorXd& residual) const;

  const World& world_;
  std::span<const Contact> contacts_;
  double step_s_;
  Eigen::VectorXd scale_;
  std::vector<Node> nodes_;  // at the trial state
  std::vector<RigidBody> rigid_bodies_;
  std::vector<SphereMotion> motion_;  // of every sphere
  BlockMatrix blocks_;
  int touching_ = 0;
};

}  // namespace stillgrid
