#pragma once

#include "shared/dynamics/engine_method.hpp"

namespace stillgrid::dynamics {

/// Ticks by the backward differentiation formulas of SUNDIALS' CVODE, which choose order and steps
/// so that the error of each step stays below a tolerance (docs/algorithms/sundials.md).
/// tolerance_m_s: relative; of velocities; and of displacements over the tick.
///
/// Each tick begins anew at order 1, so that an engine saves and loads to the bit as by any other
/// method. A tick that fails ends where CVODE came to. An engine that is made throws
/// std::runtime_error in a build without SUNDIALS (STILLGRID_SUNDIALS=OFF).
[[nodiscard]] EngineMethod by_cvode(double tolerance_m_s);

}  // namespace stillgrid::dynamics
