#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/conjugate_gradients.hpp"
#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/implicit_contacts.hpp"
#include "shared/dynamics/implicit_coupling.hpp"
#include "shared/dynamics/implicit_poses.hpp"
#include "shared/dynamics/implicit_springs.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Figures of the implicit equations of a tick.
struct SolveFigures {
  bool converged = true;
  int parts = 0;              // of the tick, so that nothing passes through a body
  int iterations = 0;         // of Newton's method
  long products = 0;          // by conjugate gradients, with the equations' derivative
  double residual_m_s = 0.0;  // rms over nodes and rigid bodies, in the last part
};

/// One step of implicit Euler: M (v1 - v0) = h f(x1, v1) + h M g with x1 = x0 + h v1, for nodes
/// and rigid bodies, springs, joints, contacts and friction.
///
/// Solves by Newton's method. Conjugate gradients solve each linear system without a matrix. The
/// derivative is symmetric and positive definite: parts of it that are not are left out. Where the
/// equations are solved, energy is never gained: each force does exactly the work that its
/// potential loses at least, and a rotation keeps angular momentum.
///
/// Deterministic. Thread: one.
class ImplicitStep {
 public:
  ImplicitStep(const Description& description, double tolerance_m_s);

  /// Leaves nodes and rigid bodies that sleep where they are. Realtime: yes.
  void leave_out(std::span<const std::uint8_t> sleeping_nodes,
                 std::span<const std::uint8_t> sleeping_rigid_bodies);
  /// Begins a step from a state, with the velocities of its start as the first guess.
  void start(const SceneState& state, double step_s);
  /// Whether the guess or solution passes through a body, or leaves the listing; after restart().
  [[nodiscard]] bool passes() const { return contacts_.any_passes(); }
  [[nodiscard]] bool is_within(const ContactListing& listing) const {
    return contacts_.all_within(listing);
  }
  /// Reads a listing that was made for this step, anew where it changed, and evaluates the guess.
  void restart(const ContactListing& listing);
  /// Iterates. Adds to counts of figures, and sets converged and the residual. Realtime: never
  /// allocates, locks or throws.
  void solve(SolveFigures& figures);
  /// The start with the velocities of the guess or solution: to list contacts for its ways.
  void write_velocities(SceneState& state) const;
  /// Moves the state to the end of the step.
  void finish(SceneState& state, RowList& rows) const;
  /// Returns what dampers and friction take in the step.
  [[nodiscard]] EnergyLosses losses() const;
  [[nodiscard]] const std::vector<Coupling>& contacts() const noexcept {
    return contacts_.couplings();
  }
  /// Impulses of all forces on a rigid body, and their moments about its centre.
  [[nodiscard]] Eigen::Vector3d impulse_N_s(std::size_t rigid) const {
    return impulses_[poses_.centre(rigid)].vector();
  }
  [[nodiscard]] Eigen::Vector3d moment_N_m_s(std::size_t rigid) const {
    return impulses_[poses_.spin(rigid)].vector();
  }

 private:
  void evaluate();
  void evaluate_body(std::size_t rigid);
  template <class Visit>
  void each_coupling(const Visit& visit) const;
  void multiply(const Motions& p, Motions& out) const;
  void factorise();
  void precondition(const Motions& r, Motions& out) const;
  [[nodiscard]] double residual_m_s() const;
  double search_line();

  const Description& description_;
  double tolerance_m_s_;
  ImplicitPoses poses_;
  ImplicitSprings springs_;
  std::vector<Coupling> joints_;
  ImplicitContacts contacts_;
  ConjugateGradients gradients_;
  MassBlocks inverses_;                       // of blocks on the diagonal of the derivative
  std::vector<Eigen::Matrix3d> spin_masses_;  // inertia at the end, and how torques change
  Motions velocities_, base_, residual_, wanted_, change_, impulses_;
  std::vector<std::size_t> nodes_, bodies_;  // those that move by forces
  std::vector<double> reaches_m_;
  std::vector<Vector4> momenta_;  // angular, of rigid bodies at the start
};

}  // namespace stillgrid::dynamics
