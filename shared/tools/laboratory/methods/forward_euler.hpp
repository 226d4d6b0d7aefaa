#pragma once

#include <memory>

#include "sim_server/dynamics/integrators/explicit_integrators.hpp"

namespace stillgrid {

/// Forward Euler: positions by the old velocities, which without dampers is unstable at every step.
class ForwardEuler : public ExplicitIntegrator {
 public:
  using ExplicitIntegrator::ExplicitIntegrator;

 private:
  void apply(const Move& move, const World& world, double step_s) override;
};

[[nodiscard]] std::unique_ptr<Integrator> make_forward_euler(const Method& method);
/// As a scene names it.
inline constexpr IntegratorKind kForwardEuler{"forward_euler", IntegratorFamily::kExplicit,
                                              make_forward_euler};

}  // namespace stillgrid
