#pragma once

#include "tests/laws/law_case.hpp"
#include "tests/laws/random.hpp"

namespace stillgrid::laws {

/// Draws what a law of a particular scene is about: a swing for refinement, a stack or a slope for
/// standing, a shot for tunnels, many bodies for cost, a pressed wall for verdicts. False, and
/// nothing drawn, for laws of any scene.
[[nodiscard]] bool draw_special(LawCase& law_case, Random& random);

}  // namespace stillgrid::laws
