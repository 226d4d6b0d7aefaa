#pragma once

#include <cstddef>
#include <vector>

#include "shared/dynamics/contact_row.hpp"
#include "shared/dynamics/contact_solver.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/joint_forces.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/spring_table.hpp"

namespace stillgrid::dynamics {

/// Energy that left a scene or entered it by other ways than gravity, springs and the springs of
/// contacts, in J. Losses are positive.
struct EnergyLosses {
  double spring_damping_J = 0.0;  // dampers of springs and joints
  double contact_damping_J = 0.0;
  double friction_J = 0.0;
  double unsolved_J = 0.0;  // a gain: springs of contacts hold it, though no work paid for it

  EnergyLosses& operator+=(const EnergyLosses& more);
};

/// Returns the scene without stiffnesses, with the springs and joints that have dampers. It has no
/// spheres.
[[nodiscard]] Description dampers_of(const Description& description);

/// Measures the losses by dampers, contacts and friction in a substep. All forces act along the
/// mean of the velocities at both ends, as position Verlet moves bodies. The sum is exact but for
/// the rounding of floats and the curvature of paths.
///
/// Thread: one. Memory is kept from substep to substep.
class LossMeter {
 public:
  explicit LossMeter(const Description& description);

  /// Begins a substep at its middle, with the velocities of its start in state and movers.
  void start(const SceneState& state, const RowList& list, const ContactBodies& bodies,
             const LiveRows& live);
  /// Ends it with the velocities of its end.
  void finish(const SceneState& state, const RowList& list, const ContactBodies& bodies,
              const LiveRows& live, double substep_s);

  /// Sums since the last clear().
  [[nodiscard]] const EnergyLosses& losses() const noexcept { return losses_; }
  void clear() { losses_ = {}; }
  /// Adds losses that were measured elsewhere.
  void add(const EnergyLosses& more) { losses_ += more; }

 private:
  /// A lane of a live row at the start of a substep.
  struct Start {
    Eigen::Vector3d velocity_m_s;  // side a relative to side b, at the point of contact
    double stretch_square_m2;
  };
  void finish_dampers(const SceneState& state, double substep_s);

  Description dampers_;  // springs and joints without their stiffness
  SpringTable table_;
  std::vector<Vector4> node_forces_N_;
  std::vector<Wrench> wrenches_;  // dampers; empty without such joints
  std::vector<Vector4> node_velocity_m_s_, rigid_velocity_m_s_, angular_velocity_rad_s_;
  std::vector<Start> starts_;  // lanes of live rows
  EnergyLosses losses_;
};

}  // namespace stillgrid::dynamics
