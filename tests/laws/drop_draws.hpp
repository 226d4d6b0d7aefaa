#pragma once

#include "tests/laws/law_case.hpp"
#include "tests/laws/random.hpp"

namespace stillgrid::laws {

/// Draws a soft block, mesh, sheet, ball or box that drops on a floor from up to 0.9 m. Its method
/// is velocity Verlet, or the default.
void draw_drop(LawCase& law_case, Random& random);

}  // namespace stillgrid::laws
