#include "tests/laws/known.hpp"

#include <string>

namespace stillgrid::laws {

namespace {

/// The value of a key, anywhere in the scene.
std::string value_of(const SceneText& scene, std::string_view key) {
  for (const SceneSection& section : scene.sections)
    if (std::string value = section.value_of(key); !value.empty()) return value;
  return {};
}

std::string integrator_of(const LawCase& law_case) {
  return value_of(law_case.scene, "integrator");
}

bool is_explicit(const LawCase& law_case) {
  const std::string integrator = integrator_of(law_case);
  return integrator == "\"velocity_verlet\"" || integrator == "\"symplectic_euler\"";
}

bool rings_or_creeps(const LawCase& law_case) {
  const std::string integrator = integrator_of(law_case);
  return integrator == "\"trapezoid\"" || integrator == "\"cvode_bdf\"";
}

}  // namespace

std::optional<std::string_view> known_violation(const LawCase& law_case) {
  const std::string& variant = law_case.variant;
  const bool answers = law_case.transition == "predict" && law_case.model == "grid";
  switch (law_case.law) {
    case 1:  // the derivatives of a force are followed however far the hand goes
      if (law_case.model == "force_jacobian") return "response per contact";
      break;
    case 2:  // one push, one direction; snapshots late by their cost
      if (answers) return "response per contact";
      // A damper meets the velocity of the last snapshot all at once.
      if ((law_case.transition == "linear" || law_case.transition == "restart") &&
          !value_of(law_case.scene, "contact_damping_N_s_per_m").empty())
        return "response per contact";
      break;
    case 3:
      if (answers && (law_case.latency_share > 0.0 || law_case.jitter > 0.0))
        return "response per contact";
      break;
    case 6:  // sums in an order that the list or a mirror decides, and where iterations end with it
      if (variant == "reversed list" || variant == "mirrored") return "contact core";
      // Places are ahead of the tool's time by half a substep, of whatever length.
      if (variant == "at 1 m/s" && integrator_of(law_case) == "\"symplectic_euler\"")
        return "contact core";
      break;
    case 7:  // what is left of the force at a switch goes at 0.2 N/ms, whatever the scene
      if (variant == "force" && answers) return "response per contact";
      break;
    case 8:  // turns of rigid bodies are of first order
      if (integrator_of(law_case) == "\"velocity_verlet\"" &&
          value_of(law_case.scene, "kind") == "\"rigid_box\"")
        return "contact core";
      break;
    case 9:  // the trapezoid gains energy of stiff contacts; explicit methods do not slow what
             // rolls, nor BDF2 what swings
      if (rings_or_creeps(law_case) || is_explicit(law_case) ||
          integrator_of(law_case) == "\"bdf2\"")
        return "contact core";
      break;
    case 10:  // the trapezoid rings; CVODE's friction is viscous below the slip speed
      if (rings_or_creeps(law_case)) return "contact core";
      break;
    case 11:  // a long step throws a ball elsewhere than a short one does, where another lay
      if (!is_explicit(law_case)) return "contact core";
      break;
    case 12:  // what a step does at once, whatever its budget, takes longer than the deadline is
      return "contact core";
    default:
      break;
  }
  return std::nullopt;
}

std::optional<std::string_view> known_violation(const LawCase& law_case, const Finding& finding) {
  constexpr double kOfDampers_N = 0.2;
  constexpr double kOneBall = 1.0;
  if (law_case.law == 11 && finding.measured > kOneBall) return std::nullopt;
  if (law_case.law == 2 && law_case.transition == "linear" &&
      !(finding.measured < 1.5 * finding.allowed + kOfDampers_N))
    return std::nullopt;
  return known_violation(law_case);
}

}  // namespace stillgrid::laws
