#pragma once

#include "tests/laws/law_case.hpp"
#include "tests/laws/random.hpp"

namespace stillgrid::laws {

/// Draws a soft block, mesh, sheet or thread that drops on a floor from up to 0.9 m, by velocity
/// Verlet or by the method of scenes that name none.
void draw_drop(LawCase& law_case, Random& random);

}  // namespace stillgrid::laws
