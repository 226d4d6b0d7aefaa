#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/trial.hpp"

namespace stillgrid::dynamics {

/// The contacts of one step, as an explicit integrator meets them substep by substep.
///
/// Springs push by the depth at a substep's start. Approach dampers and friction follow, contact
/// after contact, each as an impulse that is implicit in the relative speed it changes: neither
/// turns an approach or a slip round, so no step is too long for them, and each takes energy.
/// Nothing is allocated once there was room.
class ExplicitContacts {
 public:
  /// Takes the contacts of a step. Pre: world and contacts do not change while it lasts.
  void take(const bodies::World& world, std::span<const contact::Contact> contacts,
            const ExplicitState& state);

  /// Finds what overlaps with the tool so far on its path (share of the step) and adds the forces
  /// of the springs to `state`.
  void push(double share, ExplicitState& state);

  /// Dampers and friction of what push() found, on the velocities; what that changes of a node's
  /// also moves it, for drift_s. Adds to `flow` what they take, and what all contacts' forces do on
  /// what is moved from outside. Forces act for duration_s, a part of the step.
  void resist(double duration_s, double step_s, double drift_s, ExplicitState& state,
              EnergyFlow& flow) const;

  /// Whether any of the step's contacts has overlapped so far.
  [[nodiscard]] bool struck() const noexcept { return struck_; }

  /// That overlap at the step's end.
  [[nodiscard]] int count_touching(const ExplicitState& state);

  /// What the springs of all contacts ask for, were they pressed at once.
  struct Rates {
    double stiffness_per_s2 = 0.0;  // no eigenvalue of M^-1 K is larger
    double substeps_per_s = 0.0;    // so that bounces gain no more than 2.5 % and none is missed
  };
  [[nodiscard]] Rates rates(const ExplicitState& state, double step_s);

 private:
  /// A sphere with contacts: where it is, and how nodes take up a push.
  struct Sphere {
    int number;  // of World::spheres
    const bodies::SphereBinding* binding;
    Eigen::Vector3d position_m, arm_m;  // centre; from its rigid body's centre
    double inverse_mass_per_kg = 0.0;   // of the nodes together
  };
  /// Two spheres, or a sphere and what stands in the contact.
  struct Pair {
    int a, b;  // indices into spheres_; -1: given
    double contact_distance_m;
    const contact::Contact* contact;
  };
  struct Touch {
    const Pair* pair;
    Eigen::Vector3d normal, line_m;  // towards a; from b's centre to a's, plane: to a's lowest
    double depth_m;
  };
  struct RigidLoad {
    double pushing_N_per_m = 0.0, turning_N = 0.0;
  };
  class Side;
  struct Meeting;

  [[nodiscard]] std::optional<Touch> touch_of(const Pair& pair, double share) const;
  [[nodiscard]] static Eigen::Vector3d velocity_m_s(const Sphere& sphere,
                                                    const ExplicitState& state);
  [[nodiscard]] double approach_per_s(const Pair& pair, const ExplicitState& state,
                                      double step_s) const;
  static void press(const Sphere& sphere, const Eigen::Vector3d& force_N, ExplicitState& state);
  void place(const ExplicitState& state);

  std::vector<int> place_of_;  // of each sphere of the world in spheres_, or -1
  std::vector<Sphere> spheres_;
  std::vector<Pair> pairs_;
  std::vector<Touch> touches_;
  bool struck_ = false;
  std::vector<double> node_load_;
  std::vector<RigidLoad> rigid_load_;
};

}  // namespace stillgrid::dynamics
