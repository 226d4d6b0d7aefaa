#include "tests/laws/known.hpp"

#include <string>

namespace stillgrid {

namespace {

/// The value of a key, anywhere in the scene.
std::string value_of(const SceneText& scene, std::string_view key) {
  for (const SceneSection& section : scene.sections)
    if (std::string value = section.value_of(key); !value.empty()) return value;
  return {};
}

}  // namespace

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
    case 9: {  // impulses of one pass never rest; trapezoid and DIRK gain energy of stiff contacts
      const std::string integrator = value_of(law_case.scene, "integrator");
      if (integrator != "\"implicit_euler\"" && integrator != "\"bdf2\"") return "contact core";
      break;
    }
    case 10:  // friction is viscous below the slip speed
      return "contact core";
    case 11:  // bounds use the velocity at the step's start, and paths are taken for straight
      if (value_of(law_case.scene, "motion") == "\"prescribed\"") return "contact core";
      break;
    case 13:  // load time and a moving body's memory grow with the square
      return "scenes at their limits";
    default:
      break;
  }
  return std::nullopt;
}

}  // namespace stillgrid
