#pragma once

#include <memory>

#include "sim_server/dynamics/integrators/integrator.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::laboratory {

/// SUNDIALS' ARKODE: a diagonally implicit Runge-Kutta method of order 4, which chooses its steps
/// as SundialsIntegrator says.
[[nodiscard]] std::unique_ptr<dynamics::Integrator> make_arkode_dirk(const scene::Method& method);
/// As a scene names it.
inline constexpr scene::IntegratorKind kArkodeDirk{
    "arkode_dirk", scene::IntegratorFamily::kErrorControlled, make_arkode_dirk};

}  // namespace stillgrid::laboratory
