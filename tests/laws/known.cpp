#include "tests/laws/known.hpp"

namespace stillgrid {

std::optional<std::string_view> known_violation(const LawCase& law_case) {
  const std::string& variant = law_case.variant;
  const bool answers = law_case.transition == "answer" && law_case.model == "grid";
  switch (law_case.law) {
    case 2:  // one push, one direction; images late by their cost
      if (answers) return "response per contact";
      break;
    case 3:
      if (answers) return "response per contact";
      break;
    case 5:  // foresight sorts the list of pairs anew
      if (variant == "predicted") return "contact core";
      break;
    case 6:  // impulses in the order of the list
      if (variant == "reversed list") return "contact core";
      break;
    case 7:  // what is left of the force at a switch goes at 0.2 N/ms, whatever the scene
      if (variant == "force" && answers) return "response per contact";
      break;
    default:
      break;
  }
  return std::nullopt;
}

}  // namespace stillgrid
