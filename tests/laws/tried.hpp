#pragma once

#include <cstddef>
#include <string>

#include "tests/laws/law.hpp"

namespace stillgrid::laws {

/// What became of one case.
enum class Outcome { kHolds, kViolated, kKnown, kNotSpokenOf, kNoData, kTooLong };
inline constexpr std::size_t kOutcomes = 6;

struct Tried {
  Outcome outcome = Outcome::kHolds;
  Finding finding;
};

/// Checks the law of a case, in a process of its own. What a check throws, but for absent data, is
/// a violation, and so is a crash: a scene that is legal must run. One that takes more than 20 s of
/// processor time, or 200 s where cases are long by their law, is given up, and counted.
[[nodiscard]] Tried try_case(const LawCase& law_case);

/// "law 2 violated, seed 17: 6.13 N within a tick, at 0.356 s; allowed 0.31 N".
[[nodiscard]] std::string line_of(const LawCase& law_case, const Tried& tried);

}  // namespace stillgrid::laws
