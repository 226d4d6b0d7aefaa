#include "sim_server/dynamics/implicit_euler.hpp"

#include "sim_server/dynamics/implicit_stage.hpp"

namespace stillgrid {

SolveReport ImplicitEuler::advance(const World& world, std::span<const Contact> contacts,
                                   double duration_s, Budget& budget) {
  MechanicalSystem system(world, contacts);
  ImplicitStage stage(system, duration_s);
  Eigen::VectorXd velocity_m_s = stage.initial_guess();
  const SolveReport report = solver_->solve(stage, velocity_m_s, budget);
  trial_ = system.trial();
  return report;
}

}  // namespace stillgrid
