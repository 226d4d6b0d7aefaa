#pragma once

#include <memory>

#include "sim_server/dynamics/integrator.hpp"

namespace stillgrid {

/// Implicit (backward) Euler in velocities: unconditionally stable, first order, and dissipative
/// [Davanne 2002, section 5].
class ImplicitEuler : public Integrator {
 public:
  explicit ImplicitEuler(std::unique_ptr<NonlinearSolver> solver) : solver_(std::move(solver)) {}

  SolveReport advance(const World& world, std::span<const Contact> contacts, double duration_s,
                      Budget& budget) override;

 private:
  std::unique_ptr<NonlinearSolver> solver_;
};

}  // namespace stillgrid
