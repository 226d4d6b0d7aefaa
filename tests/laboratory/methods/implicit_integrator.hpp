#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "sim_server/dynamics/contacts/contact_memory.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/integrators/implicit_stage.hpp"
#include "sim_server/dynamics/integrators/integrator.hpp"

namespace stillgrid::laboratory {

/// Implicit Euler in velocities [Davanne 2002, section 5]: of first order; a step takes energy out.
/// Rotations follow the same formula by rotation vectors. The dampers of contacts act over the
/// step.
///
/// Contacts stick up to the friction: their stretches last from step to step.
///
/// A step that does not converge is scaled back towards rest, velocities and displacements alike,
/// until it has no more energy than at its start. That is kinetic energy, and energy of gravity,
/// springs and springs of contacts. Given motion, as the tool's, is taken to have happened first,
/// and may so have worked.
class ImplicitIntegrator : public dynamics::Integrator {
 public:
  explicit ImplicitIntegrator(std::unique_ptr<dynamics::NonlinearSolver> solver)
      : solver_(std::move(solver)) {}

  [[nodiscard]] dynamics::IntegratorTraits traits() const noexcept override {
    return {.solves = true};
  }
  dynamics::SolveReport advance(const bodies::World& world,
                                std::span<const contact::Contact> contacts, double duration_s,
                                dynamics::Budget& budget) override;
  void commit(bodies::World& world, double duration_s) override;
  [[nodiscard]] dynamics::ContactMemories* memories() override { return &memories_; }

 private:
  void load(const bodies::World& world, std::span<const contact::Contact> contacts);
  void end_with(std::span<const contact::Contact> contacts, double duration_s);
  bool make_safe(const Eigen::VectorXd& start_velocity, double duration_s);

  std::unique_ptr<dynamics::NonlinearSolver> solver_;
  dynamics::MechanicalSystem system_;
  dynamics::ContactMemories memories_;
  std::vector<Eigen::Vector3d> stretches_m_, ended_m_;  // contacts at the start and the end
  Eigen::VectorXd velocity_, displacement_;             // the trial's
};

}  // namespace stillgrid::laboratory
