#include "tests/laws/known.hpp"

#include <algorithm>
#include <string>

namespace stillgrid::laws {

namespace {

/// What no step of the plan mends: the method is so.
constexpr std::string_view kOfItsMethod = "a limit of its method";
/// Rounding decides whether a step has one substep more.
constexpr std::string_view kOtherSubsteps = "substeps counted otherwise";
/// A spring that passes through its zero length turns its force about within a substep.
constexpr std::string_view kThroughZero = "a spring that passes through zero length";

/// A proxy slides without friction, into other valleys between the spheres of a cover.
constexpr std::string_view kValleys = "a proxy that sticks between spheres";

/// At an edge of a cover the smooth plane turns with the proxy, and its normal is no gradient.
constexpr std::string_view kAtEdges = "a cover whose force has a potential at its edges";

/// Coarse cells round the edges of a mesh, and spheres leave parts of them out.
constexpr std::string_view kOfCells = "cells or spheres that follow the edges of a mesh";

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
  return integrator_of(law_case) == "\"velocity_verlet\"";
}

bool is_by_cvode(const LawCase& law_case) {
  return integrator_of(law_case) == "\"cvode_bdf\"";
}

bool is_late(const LawCase& law_case) {
  return law_case.latency_share > 0.0 || law_case.jitter > 0.0;
}

/// Whether a body is covered with spheres.
bool has_spheres(const LawCase& law_case) {
  return std::ranges::any_of(law_case.scene.sections, [](const SceneSection& section) {
    return section.head == "[[body]]" && !section.value_of("spheres").empty();
  });
}

bool steps_otherwise(const LawCase& law_case) {
  const std::string integrator = integrator_of(law_case);
  return !integrator.empty() && integrator != "\"implicit_euler\"";
}

}  // namespace

std::optional<std::string_view> known_violation(const LawCase& law_case) {
  const std::string& variant = law_case.variant;
  switch (law_case.law) {
    case 1:  // the derivatives of a force are followed however far the hand goes
      if (law_case.model == "force_jacobian") return kOfItsMethod;
      // A plane reaches beyond the body that it was laid on.
      if (law_case.model == "plane") return kOfItsMethod;
      break;
    case 2:
      // They show what was: what came late, or went otherwise by long steps, at a kink; and a
      // damper meets the velocity of the last snapshot all at once.
      if (law_case.transition != "local" &&
          (is_late(law_case) || steps_otherwise(law_case) ||
           !value_of(law_case.scene, "contact_damping_N_s_per_m").empty()))
        return kOfItsMethod;
      break;
    case 6:  // sums in an order that the list or a mirror decides, and where iterations end with it
      if (variant == "reversed list" || variant == "mirrored") return kOfItsMethod;
      if (variant == "at 1 m/s" && is_explicit(law_case)) return kOtherSubsteps;
      break;
    case 9:  // explicit methods do not slow what rolls, nor any what swings across its springs,
             // whose dampers act along them
      return kOfItsMethod;
    case 11:  // a long step throws a ball elsewhere than a short one does, where another lay
      if (!is_explicit(law_case)) return kOfItsMethod;
      break;
    case 12:  // what a step does at once, whatever its budget, takes longer than the deadline is
      return kOfItsMethod;
    case 16:  // what an undamped soft body gains as it crumples, until EnergyWatch ends the run
      if (is_explicit(law_case) && !value_of(law_case.scene, "spring_stiffness_N_per_m").empty() &&
          value_of(law_case.scene, "spring_damping_N_s_per_m").empty())
        return kThroughZero;
      break;
    case 18:
      if (has_spheres(law_case) && (variant == "hold" || variant == "grip")) return kValleys;
      if (has_spheres(law_case) && variant == "closed path") return kAtEdges;
      if (variant == "cover" && !value_of(law_case.scene, "file").empty()) return kOfCells;
      break;
    default:
      break;
  }
  return std::nullopt;
}

std::optional<std::string_view> known_violation(const LawCase& law_case, const Finding& finding) {
  constexpr double kOneBall = 1.0;
  constexpr double kOfASwing = 100.0;  // what moves at some mm/s, where 1 is allowed
  const bool may_move_on = is_by_cvode(law_case) || is_explicit(law_case);
  if (law_case.law == 9 && !may_move_on && finding.allowed > 0.0 &&
      finding.measured > kOfASwing * finding.allowed)
    return std::nullopt;
  constexpr double kCrumpled = 5.0;  // of what is allowed, a tenth of the largest kinetic energy
  if (law_case.law == 16 && finding.measured > kCrumpled * finding.allowed) return std::nullopt;
  constexpr double kOfTheForce = 0.25;  // by which half of a cell changes it
  constexpr double kBySpheres = 0.1;
  const bool has_field = !value_of(law_case.scene, "field").empty();
  if (law_case.law == 18 && law_case.variant == "cover" &&
      finding.measured > (has_field ? kOfTheForce : kBySpheres))
    return std::nullopt;
  constexpr double kOfTheWork = 100.0;  // of what is allowed, 0.1 % of the work to and fro
  if (law_case.law == 18 && law_case.variant == "closed path" &&
      finding.measured > kOfTheWork * finding.allowed)
    return std::nullopt;
  if (law_case.law == 11 && finding.measured > kOneBall) return std::nullopt;
  return known_violation(law_case);
}

}  // namespace stillgrid::laws
