#pragma once

#include <Eigen/Core>
#include <span>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/contact/detection.hpp"
#include "sim_server/dynamics/integrators/integrator.hpp"

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

[[nodiscard]] double kinetic_energy_J(const bodies::World& world, const bodies::BodyRange& body);

/// Takes a pass over nodes, rigid bodies, springs and joints; contacts_J stays zero.
[[nodiscard]] Energies energies_without_contacts(const bodies::World& world);

/// Returns the energy of the contacts' springs at the start of the step they were found for, J.
[[nodiscard]] double contact_energy_J(std::span<const contact::Contact> contacts);

/// Contacts are looked for anew, among sleeping bodies too, which costs far more than a step.
/// tool: the spheres of all tools where they are; none without a tool.
[[nodiscard]] Energies energies(const bodies::World& world,
                                const std::vector<contact::ToolSphereMotion>& tool);

/// What the springs of the tool's contacts hold at the start of the step that they were found for.
[[nodiscard]] double tool_energy_J(std::span<const contact::Contact> contacts);

/// What flows over a step of an integrator that does not look within: every force as it is at its
/// end, along the way that velocities there make of the step; of what is given, of contact springs
/// and of what sticks, the mean of both ends' where the trial tells how contacts began. The
/// approach damper takes its mean force times how much deeper it came, as contact_force() has it.
/// Friction and springs' dampers take force times velocity; what the tool or a prescribed body
/// gives is the force on the other side times the way of this one. Pre: after is where a step of
/// duration_s from `before` led.
[[nodiscard]] EnergyFlow energy_flow(const bodies::World& before, const Trial& after,
                                     std::span<const contact::Contact> contacts, double duration_s);

/// Of it what the tools give. Pre: their contacts stand last.
[[nodiscard]] EnergyByHand_J tool_flow_J(const bodies::World& before, const Trial& after,
                                         std::span<const contact::Contact> contacts,
                                         double duration_s);

/// What the tools give to what a prescribed motion leads, which no energy of the world knows of:
/// the mean of the spring's forces at start and end, else as above.
[[nodiscard]] EnergyByHand_J led_flow_J(const bodies::World& before, const Trial& after,
                                        std::span<const contact::Contact> contacts,
                                        double duration_s);

EnergyByHand_J& operator+=(EnergyByHand_J& sum, const EnergyByHand_J& flow);
EnergyFlow& operator+=(EnergyFlow& sum, const EnergyFlow& flow);

/// Of everything that is free.
[[nodiscard]] Eigen::Vector3d momentum_kg_m_per_s(const bodies::World& world);
/// About the origin.
[[nodiscard]] Eigen::Vector3d angular_momentum_kg_m2_per_s(const bodies::World& world);

}  // namespace stillgrid::dynamics
