#pragma once

#include <memory>

#include "sim_server/dynamics/integrators/explicit_integrators.hpp"

namespace stillgrid::laboratory {

/// Forward Euler: positions by the old velocities, which without dampers is unstable at every step.
class ForwardEuler : public dynamics::ExplicitIntegrator {
 public:
  using dynamics::ExplicitIntegrator::ExplicitIntegrator;

 private:
  void apply(const dynamics::Move& move, const bodies::World& world, double step_s) override;
};

[[nodiscard]] std::unique_ptr<dynamics::Integrator> make_forward_euler(const scene::Method& method);
/// As a scene names it.
inline constexpr scene::IntegratorKind kForwardEuler{
    "forward_euler", scene::IntegratorFamily::kExplicit, make_forward_euler};

}  // namespace stillgrid::laboratory
