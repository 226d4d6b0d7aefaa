#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <vector>

#include "shared/dynamics/conjugate_gradients.hpp"
#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/energy_losses.hpp"
#include "shared/dynamics/engine_method.hpp"
#include "shared/dynamics/implicit_contacts.hpp"
#include "shared/dynamics/implicit_coupling.hpp"
#include "shared/dynamics/implicit_poses.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/sleep.hpp"

namespace stillgrid::dynamics {

/// A step of a whole scene at once, by a method that needs all of its contacts beforehand. An
/// engine lists contacts for a step, lets it solve, and halves a step that does not succeed.
///
/// A step depends on its start and its listing alone. It does not remember the step before.
///
/// Thread: one. Memory is kept from step to step.
class CoupledStep {
 public:
  /// Pre: the description outlives this.
  explicit CoupledStep(const Description& description);
  virtual ~CoupledStep() = default;
  CoupledStep(const CoupledStep&) = delete;
  CoupledStep& operator=(const CoupledStep&) = delete;
  CoupledStep(CoupledStep&&) = delete;
  CoupledStep& operator=(CoupledStep&&) = delete;

  /// Leaves all that sleeps where it is. Realtime: yes.
  virtual void leave_out(const Sleep& sleep);
  /// Begins a step from a state, with the velocities of its start as the first guess. Pre: the
  /// state does not change until finish().
  virtual void start(const SceneState& state, double step_s);
  /// Reads a listing that was made for this step, anew where it changed.
  virtual void restart(const ContactListing& listing) = 0;
  /// Solves, until stop is true if it is not null. Adds to counts of figures, and sets converged
  /// and the residual.
  virtual void solve(SolveFigures& figures, const std::atomic<bool>* stop) = 0;
  /// Whether the guess or solution passes through a body; after restart().
  [[nodiscard]] virtual bool passes() const { return contacts_.any_passes(); }
  /// Whether the solution stays on the ways that contacts were listed for.
  [[nodiscard]] bool is_within(const ContactListing& listing) const {
    return contacts_.all_within(listing);
  }
  /// The start with the velocities of the guess or solution: to list contacts for its ways.
  void write_velocities(SceneState& state) const;
  /// Moves the state, the contacts of the listing and the places of spheres to the end of the step.
  void finish(SceneState& state, ContactListing& listing, std::vector<SpherePlace>& places) const;
  /// Returns the losses by dampers and friction in the step.
  [[nodiscard]] virtual EnergyLosses losses() const = 0;
  /// Adds the impulses and moments of the step on a driven body.
  void add_reaction(std::size_t rigid, DrivenReaction& reaction) const;

 protected:
  /// Adds the impulses of all contacts to impulses_ and driven_impulses_.
  void add_contact_impulses();

  const Description& description_;
  ImplicitPoses poses_;
  ImplicitContacts contacts_;
  AwakeRuns awake_;
  std::vector<std::size_t> nodes_, bodies_;  // those that move by forces
  std::vector<double> reaches_m_;            // rigid bodies: their farthest points
  Motions velocities_;                       // guess or solution
  Motions impulses_;                         // sums of all forces over the step
  Motions driven_impulses_;                  // part of them by contacts between driven bodies
};

}  // namespace stillgrid::dynamics
