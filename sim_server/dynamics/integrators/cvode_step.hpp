#pragma once

#include "shared/dynamics/engine_method.hpp"

namespace stillgrid::dynamics {

/// Returns ticks by the backward differentiation formulas of SUNDIALS' CVODE. They choose order and
/// steps: the error of each step stays below a tolerance (docs/algorithms/sundials.md). The
/// relative error and that of velocities are tolerance_m_s. Displacements may err by it times the
/// tick.
///
/// Each tick begins anew at order 1, so that an engine saves and loads to the bit as by any other
/// method. A tick that fails ends at the state that CVODE reached. An engine that is made throws
/// std::runtime_error in a build without SUNDIALS (STILLGRID_SUNDIALS=OFF).
[[nodiscard]] EngineMethod by_cvode(double tolerance_m_s);

}  // namespace stillgrid::dynamics
