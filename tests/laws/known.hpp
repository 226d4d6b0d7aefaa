#pragma once

#include <optional>
#include <string_view>

#include "tests/laws/law.hpp"

namespace stillgrid::laws {

/// The step that will mend it, where a law is known not to hold for cases of this sort: violations
/// among them are counted and do not fail a run. None: the law holds.
///
/// Each sort has a shrunk scene in the corpus. scripts/laws fails for a sort of which a long run
/// found no violation any more: the list stays true.
[[nodiscard]] std::optional<std::string_view> known_violation(const LawCase& law_case);

/// The same for one violation: a sort may be known to break a law by so much and no more.
[[nodiscard]] std::optional<std::string_view> known_violation(const LawCase& law_case,
                                                              const Finding& finding);

}  // namespace stillgrid::laws
