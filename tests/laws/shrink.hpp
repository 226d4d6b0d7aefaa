#pragma once

#include "tests/laws/law_case.hpp"

namespace stillgrid::laws {

/// The smallest case found, in so many tries, that still breaks the law: without a body, a key or a
/// sphere of the tool that it does not need, shorter, with round numbers and default options. The
/// case itself where it breaks none.
[[nodiscard]] LawCase shrink(const LawCase& law_case, int tries);

}  // namespace stillgrid::laws
