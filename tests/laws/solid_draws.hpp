#pragma once

#include "tests/laws/law_case.hpp"
#include "tests/laws/random.hpp"

namespace stillgrid::laws {

/// Draws a case of the law of solids. The variant names the part that is checked: "face", "seam",
/// "corner", "ball", "through", "cover", "hold", "grip", "closed path" or "soft". No body has
/// gravity but the block of "grip". Other bodies but that of "soft" are static, or free and too
/// heavy to move. Faces that the tool presses are in z = 0.
void draw_solid(LawCase& law_case, Random& random);

}  // namespace stillgrid::laws
