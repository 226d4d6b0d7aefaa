#pragma once

#include <optional>
#include <span>

#include "sim_server/dynamics/forces/explicit_contacts.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/spring_forces.hpp"
#include "sim_server/dynamics/forces/spring_spectrum.hpp"
#include "sim_server/dynamics/integrators/integrator.hpp"

namespace stillgrid::dynamics {

/// Explicit integration in substeps: v += h a(x, v), then x += h v by the new velocities
/// (symplectic Euler). Velocity Verlet is the same with half of the first kick, and the other half
/// by the forces at the end: of second order, but for dampers and friction.
///
/// With dampers both are stable where h^2 lambda_K + 2 h lambda_C < 4, for the
/// largest eigenvalues of M^-1 K and M^-1 C. Without a given number of substeps there are as many
/// as that asks. Rigid bodies carry their angular momentum, so that a free one keeps it exactly.
/// Contact dampers and friction: see ExplicitContacts.
class ExplicitIntegrator : public Integrator {
 public:
  /// Pre: is_explicit(method.integrator).
  explicit ExplicitIntegrator(const scene::Method& method) : method_(method) {}

  [[nodiscard]] IntegratorTraits traits() const noexcept override;

  /// An iteration is a substep, and the budget's iterations are not asked. Beyond its deadline the
  /// trial is the state reached: the world runs late, unharmed, and did not converge.
  SolveReport advance(const bodies::World& world, std::span<const contact::Contact> contacts,
                      double duration_s, Budget& budget) override;

  [[nodiscard]] std::optional<EnergyFlow> flow() const override { return flow_; }
  void restart() override;

  /// Of the last advance().
  [[nodiscard]] int substeps() const noexcept { return substeps_; }

 protected:
  /// What a substep makes of the forces: by the order of its parts a method differs. step_s: of the
  /// whole advance().
  virtual void apply(const Move& move, const bodies::World& world, double step_s);
  [[nodiscard]] ExplicitState& state() noexcept { return state_; }
  /// Forces change the velocities of rigid bodies; these move them.
  void kick(const bodies::World& world, double kick_s);
  void drift(double drift_s);
  /// Dampers and friction of contacts, as ExplicitContacts::resist().
  void resist(double kick_s, double step_s, double drift_s) {
    contacts_.resist(kick_s, step_s, drift_s, state_, flow_);
  }

 private:
  void pack(const bodies::World& world);
  [[nodiscard]] int substeps_for(const bodies::World& world, double duration_s);
  void substep(const bodies::World& world, double from_s, const Move& move, double step_s);
  [[nodiscard]] bool unpack(const bodies::World& world, double duration_s);
  void rest(const bodies::World& world);

  scene::Method method_;
  std::optional<SpringForces> springs_;
  static constexpr int kNeverLooked = 1 << 20;
  SpringSpectrum spectrum_;
  SpringRates rates_;
  int since_look_ = kNeverLooked;  // substeps since the spectrum was followed
  ExplicitContacts contacts_;
  ExplicitState state_;
  EnergyFlow flow_;
  int substeps_ = 0;
};

}  // namespace stillgrid::dynamics
