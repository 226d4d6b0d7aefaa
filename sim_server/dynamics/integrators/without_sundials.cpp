#include <stdexcept>
#include <string>

#include "sim_server/dynamics/integrators/sundials_integrator.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::dynamics {

std::unique_ptr<Integrator> make_cvode_integrator(double /*tolerance_m_s*/) {
  throw std::runtime_error(std::string(scene::IntegratorKind::kCvodeBdf.name) +
                           ": this build is without SUNDIALS");
}

}  // namespace stillgrid::dynamics
