#pragma once

#include <cstdint>
#include <string>

#include "tests/laws/law.hpp"

namespace stillgrid {

/// What became of one case.
enum class Outcome { kHolds, kViolated, kKnown, kNotSpokenOf, kNoData };

struct Tried {
  Outcome outcome = Outcome::kHolds;
  Finding finding;
};

/// Checks the law of a case. What a check throws, but for absent data, is a violation: a scene that
/// is legal must run.
[[nodiscard]] Tried try_case(const LawCase& law_case);

/// "law 2 violated, seed 17: 6.13 N within a tick, at 0.356 s; allowed 0.31 N".
[[nodiscard]] std::string line_of(const LawCase& law_case, const Tried& tried);

}  // namespace stillgrid
