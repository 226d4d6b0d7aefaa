#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "sim_server/dynamics/contacts/contact_memory.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/integrators/implicit_stage.hpp"
#include "sim_server/dynamics/integrators/integrator.hpp"

namespace stillgrid::dynamics {

/// Implicit integrators of one stage a step, in velocities; h is the step:
///   implicit Euler      q* = 0                p* = p_n                        s = h
///   BDF2, even steps    q* = (q_n-q_{n-1})/3  p* = p_n + (p_n-p_{n-1})/3      s = 2h/3
///   trapezoid           q* = h/2 u_n          p* = p_n + h/2 f_n              s = h/2
/// with the formula for uneven steps where BDF2's steps differ [Hairer, Norsett, Wanner 1993,
/// III.5]. Implicit Euler [Davanne 2002, section 5] is of first order and takes energy out; BDF2 is
/// of second order, L-stable, and takes out little of what its step resolves; the trapezoid takes
/// out none, so it rings where a step is too long. Rotations follow the same formulas by rotation
/// vectors.
///
/// BDF2 begins anew, with implicit Euler, after restart(), after a step of less than half the
/// length or one that did not converge, and when the world's velocities are not those it left. The
/// approach dampers of contacts act over h, in the trapezoid over h/2, where alone its end's forces
/// act.
///
/// What touches sticks, up to the friction: stretches last from step to step. In the trapezoid they
/// grow over the whole step, and their dampers act as the approach dampers.
///
/// A step that does not converge is led back towards rest where it was, velocities and
/// displacements alike, until it has no more energy (kinetic, gravity, springs, springs of
/// contacts) than at its start; what is given, as the tool, is taken to have moved first, and may
/// so have worked.
class ImplicitIntegrator : public Integrator {
 public:
  /// Pre: kind is kImplicitEuler, kBdf2 or kTrapezoid.
  ImplicitIntegrator(const scene::IntegratorKind& kind, std::unique_ptr<NonlinearSolver> solver)
      : kind_(kind), solver_(std::move(solver)) {}

  [[nodiscard]] IntegratorTraits traits() const noexcept override { return {.solves = true}; }
  SolveReport advance(const bodies::World& world, std::span<const contact::Contact> contacts,
                      double duration_s, Budget& budget) override;
  SolveReport correct(const bodies::World& world, std::span<const contact::Contact> contacts,
                      double duration_s, Budget& budget) override;
  void commit(bodies::World& world, double duration_s) override;
  void restart() override { history_.duration_s = 0.0; }
  [[nodiscard]] ContactMemories* memories() override { return &memories_; }

 private:
  /// The step before: how far it led, and the momentum it began with.
  struct History {
    double duration_s = 0.0;  // zero: none
    Eigen::VectorXd displacement, momentum;
    Eigen::VectorXd end_velocity;
  };
  StageRule rule(const Eigen::VectorXd& start_velocity, double duration_s);
  void take(const bodies::World& world, std::span<const contact::Contact> contacts);
  void end_with(std::span<const contact::Contact> contacts, double contact_step_s);
  bool make_safe(const Eigen::VectorXd& start_velocity, double duration_s);

  scene::IntegratorKind kind_;
  bool is_true_ = true;  // the last advance() converged
  std::unique_ptr<NonlinearSolver> solver_;
  History history_;
  MechanicalSystem system_;
  ContactMemories memories_;
  std::vector<Eigen::Vector3d> stretches_m_, ended_m_;  // of the contacts, as they begin and end
  Eigen::VectorXd velocity_, start_momentum_, displacement_;  // of the trial
};

}  // namespace stillgrid::dynamics
