#pragma once

#include <optional>
#include <span>

#include "sim_server/dynamics/contacts/contact_core.hpp"
#include "sim_server/dynamics/forces/explicit_joints.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/spring_bound.hpp"
#include "sim_server/dynamics/forces/spring_forces.hpp"
#include "sim_server/dynamics/integrators/integrator.hpp"

namespace stillgrid::dynamics {

/// Velocity Verlet in substeps h: x += h/2 v, v += h a(x, v), x += h/2 v. Forces are those of the
/// substep's middle: of second order but for springs' dampers.
///
/// With dampers it is stable where h^2 lambda_K + 2 h lambda_C < 4, for the largest eigenvalues
/// of M^-1 K and M^-1 C of the springs; contacts are held by ContactCore, which asks for no
/// substeps. Without a given number of substeps there are as many as that asks, and twice as many
/// where contacts cannot be solved. Rigid bodies carry their angular momentum, so that a free one
/// keeps it exactly.
class ExplicitIntegrator : public Integrator {
 public:
  /// Pre: is_explicit(method.integrator).
  explicit ExplicitIntegrator(const scene::Method& method) : method_(method) {}

  [[nodiscard]] IntegratorTraits traits() const noexcept override;

  /// An iteration is a substep, and the budget's iterations are not asked. Beyond its deadline the
  /// trial is the state reached: the world runs late, unharmed, and did not converge.
  SolveReport advance(const bodies::World& world, std::span<const contact::Contact> contacts,
                      double duration_s, Budget& budget) override;

  void commit(bodies::World& world, double duration_s) override;
  [[nodiscard]] std::optional<EnergyFlow> flow() const override { return flow_; }
  [[nodiscard]] ContactMemories* memories() override { return &contacts_.memories(); }
  void share_work(const Workers& workers) override;
  void restart() override;

  /// Of the last advance().
  [[nodiscard]] int substeps() const noexcept { return substeps_; }

 private:
  void kick(const bodies::World& world, double kick_s);
  void drift(const bodies::World& world, double drift_s);
  void pack(const bodies::World& world);
  [[nodiscard]] int substeps_for(const bodies::World& world, double duration_s);
  SolveReport move(const bodies::World& world, double duration_s, bool may_halve,
                   const Budget& budget);
  SolveReport move_freely(const bodies::World& world, double duration_s, const Budget& budget);
  void kick_rigid(const bodies::World& world, double kick_s);
  void drift_rigid(double drift_s);
  ContactSolve substep(const bodies::World& world, double at_s, double substep_s, double step_s,
                       const Budget& budget);
  void unpack(const bodies::World& world, double duration_s);
  /// work(body) for each rigid body that feels forces, by those who share it.
  template <class Work>
  void for_each_free(const Work& work);

  scene::Method method_;
  const Workers* workers_ = &Workers::alone();
  std::optional<SpringForces> springs_;
  std::optional<JointSpectrum> joints_;
  SpringRates spring_rates_;  // bounds for springs_
  ContactCore contacts_;
  // Of what touched in the last advance(), and in the last that counts.
  double contact_rate_per_s2_ = 0.0, kept_contact_rate_per_s2_ = 0.0;
  ExplicitState state_;
  EnergyFlow flow_;
  int substeps_ = 0;
};

}  // namespace stillgrid::dynamics
