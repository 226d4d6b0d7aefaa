#include "tests/laws/tried.hpp"

#include <exception>
#include <limits>

#include "tests/laws/known.hpp"

namespace stillgrid {

Tried try_case(const LawCase& law_case) {
  Tried tried;
  try {
    tried.finding = law_of(law_case.law).check(law_case);
  } catch (const NoData& error) {
    tried.outcome = Outcome::kNoData;
    tried.finding.what = error.what();
    return tried;
  } catch (const std::exception& error) {
    tried.finding = {.measured = std::numeric_limits<double>::infinity(),
                     .what = std::string("thrown: ") + error.what()};
  }
  if (!tried.finding.applies)
    tried.outcome = Outcome::kNotSpokenOf;
  else if (!tried.finding.holds())
    tried.outcome = known_violation(law_case) ? Outcome::kKnown : Outcome::kViolated;
  return tried;
}

std::string line_of(const LawCase& law_case, const Tried& tried) {
  static constexpr const char* kWords[] = {"holds", "violated", "violated as known",
                                           "does not apply", "has no data"};
  return "law " + std::to_string(law_case.law) + " " +
         kWords[static_cast<std::size_t>(tried.outcome)] + ", seed " +
         std::to_string(law_case.seed) + ": " + short_number(tried.finding.measured) + " " +
         tried.finding.what + "; allowed " + short_number(tried.finding.allowed);
}

}  // namespace stillgrid
