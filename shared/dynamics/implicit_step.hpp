#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <vector>

#include "shared/dynamics/conjugate_gradients.hpp"
#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/engine_method.hpp"
#include "shared/dynamics/implicit_contacts.hpp"
#include "shared/dynamics/implicit_coupling.hpp"
#include "shared/dynamics/implicit_poses.hpp"
#include "shared/dynamics/implicit_springs.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/sleep.hpp"

namespace stillgrid::dynamics {

/// One step of implicit Euler: M (v1 - v0) = h f(x1, v1) + h M g with x1 = x0 + h v1. It moves
/// nodes and rigid bodies by springs, joints, contacts and friction.
///
/// Solves by Newton's method. Conjugate gradients solve each linear system without a matrix. The
/// derivative is symmetric and positive definite: parts of it that are not are left out. A solved
/// step never gains energy: each force does at most the work that its potential loses. A rotation
/// keeps angular momentum.
///
/// Deterministic. Thread: one.
class ImplicitStep {
 public:
  ImplicitStep(const Description& description, double tolerance_m_s);

  /// Leaves all that sleeps where it is. Realtime: yes.
  void leave_out(const Sleep& sleep);
  /// Begins a step from a state, with the velocities of its start as the first guess.
  void start(const SceneState& state, double step_s);
  /// Whether the guess or solution passes through a body, or turns one too far for the work of its
  /// forces to be exact; after restart().
  [[nodiscard]] bool passes() const { return contacts_.any_passes() || turns_far(); }
  /// Whether the guess or solution stays within the ways of the listing.
  [[nodiscard]] bool is_within(const ContactListing& listing) const {
    return contacts_.all_within(listing);
  }
  /// Reads a listing that was made for this step, anew where it changed, and evaluates the guess.
  void restart(const ContactListing& listing);
  /// Iterates, until stop is true if it is not null. Adds to counts of figures, and sets converged
  /// and the residual. Realtime: never allocates, locks or throws.
  void solve(SolveFigures& figures, const std::atomic<bool>* stop);
  /// The start with the velocities of the guess or solution: to list contacts for its ways.
  void write_velocities(SceneState& state) const;
  /// Moves the state, the contacts of the listing and the places of spheres to the end of the step.
  void finish(SceneState& state, ContactListing& listing, std::vector<SpherePlace>& places) const;
  /// Returns the losses by dampers and friction in the step.
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
  void collect_active();
  [[nodiscard]] bool turns_far() const;
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
  std::vector<const Coupling*> active_;  // joints and contacts of the last evaluate()
  AwakeRuns awake_;
  ConjugateGradients gradients_;
  MassBlocks inverses_;                       // blocks on the diagonal of the derivative
  std::vector<Eigen::Matrix3d> spin_masses_;  // inertia at the end, and how torques change
  Motions velocities_, base_, residual_, wanted_, change_, impulses_;
  std::vector<std::size_t> nodes_, bodies_;  // those that move by forces
  std::vector<double> reaches_m_;
  std::vector<Vector4> momenta_;  // angular, of rigid bodies at the start
};

}  // namespace stillgrid::dynamics
