#pragma once

#include <Eigen/Core>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/ticks/energy_flow.hpp"

namespace stillgrid::dynamics {

/// The energy that a world holds, J: of all that is not prescribed, awake or sleeping.
struct Energies {
  double kinetic_J = 0.0;
  double gravity_J = 0.0;  // zero at the origin
  double springs_J = 0.0;
  double contacts_J = 0.0;  // of the springs that touching spheres press, the tool's too, and of
                            // what sticks

  [[nodiscard]] double total_J() const { return kinetic_J + gravity_J + springs_J + contacts_J; }
};

/// What became of a run's energy: start + given - damping - friction - sleep loss - numerical =
/// end.
struct EnergyAccount {
  Energies start, end;
  EnergyFlow flow;
  double sleep_loss_J = 0.0;  // kinetic energy of what went to sleep

  /// What the integrator lost; negative if it gained.
  [[nodiscard]] double numerical_J() const {
    return start.total_J() + flow.given_J - flow.spring_damping_J - flow.contact_damping_J -
           flow.friction_J - sleep_loss_J - end.total_J();
  }
};

/// Takes a pass over nodes, rigid bodies, springs and joints; contacts_J stays zero.
[[nodiscard]] Energies energies_without_contacts(const bodies::World& world);

EnergyByHand_J& operator+=(EnergyByHand_J& sum, const EnergyByHand_J& flow);
EnergyFlow& operator+=(EnergyFlow& sum, const EnergyFlow& flow);

/// Of everything that is free.
[[nodiscard]] Eigen::Vector3d momentum_kg_m_per_s(const bodies::World& world);
/// About the origin.
[[nodiscard]] Eigen::Vector3d angular_momentum_kg_m2_per_s(const bodies::World& world);

}  // namespace stillgrid::dynamics
