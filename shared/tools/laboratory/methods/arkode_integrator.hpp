#pragma once

#include <memory>

#include "sim_server/dynamics/integrators/integrator.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid {

/// SUNDIALS' ARKODE: a diagonally implicit Runge-Kutta method of order 4, which chooses its steps
/// as SundialsIntegrator says.
[[nodiscard]] std::unique_ptr<Integrator> make_arkode_dirk(const Method& method);
/// As a scene names it.
inline constexpr IntegratorKind kArkodeDirk{"arkode_dirk", IntegratorFamily::kErrorControlled,
                                            make_arkode_dirk};

}  // namespace stillgrid
