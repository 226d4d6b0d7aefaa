#include <stdexcept>

#include "shared/dynamics/coupled_step.hpp"
#include "sim_server/dynamics/integrators/cvode_step.hpp"

namespace stillgrid::dynamics {

EngineMethod by_cvode(double tolerance_m_s) {
  const auto make = [](const Description&, double) -> std::unique_ptr<CoupledStep> {
    throw std::runtime_error("cvode_bdf: this build is without SUNDIALS");
  };
  return {.make = make, .tolerance_m_s = tolerance_m_s};
}

}  // namespace stillgrid::dynamics
