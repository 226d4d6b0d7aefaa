#pragma once

#include <memory>

#include "sim_server/dynamics/integrators/explicit_integrators.hpp"

namespace stillgrid::laboratory {

/// Forward Euler: positions by the old velocities, which without dampers is unstable at every step.
class ForwardEuler : public dynamics::ExplicitIntegrator {
 public:
  /// Pre: method.integrator is kForwardEuler.
  explicit ForwardEuler(const scene::Method& method) : ExplicitIntegrator(method, {0.0, 0.0}) {}

 private:
  void apply(const bodies::World& world, double substep_s) override;
};

[[nodiscard]] std::unique_ptr<dynamics::Integrator> make_forward_euler(const scene::Method& method);
/// As a scene names it.
inline constexpr scene::IntegratorKind kForwardEuler{
    "forward_euler", scene::IntegratorFamily::kExplicit, make_forward_euler};

}  // namespace stillgrid::laboratory
