#pragma once

#include <span>
#include <string>
#include <string_view>

#include "tests/laws/law_case.hpp"

namespace stillgrid::laws {

/// What a law found in a case: it holds where what was measured is no more than what is allowed.
struct Finding {
  bool applies = true;    // false: the law does not speak of such a case, `what` says why
  double measured = 0.0;  // infinite for what is no number
  double allowed = 0.0;
  std::string what;  // with the unit, and where

  [[nodiscard]] bool holds() const { return !applies || measured <= allowed; }
};

/// A law that holds in every scene, or in a stated sort of them: docs/laws.md.
struct Law {
  int number = 0;
  std::string_view name, statement;
  /// Throws what run_lab() and Simulation throw, NoData.
  Finding (*check)(const LawCase&) = nullptr;
  int short_seeds = 0;  // that the common tests try
  int per_hour = 0;     // cases that one processor tries in an hour, about
};

[[nodiscard]] std::span<const Law> all_laws();
/// Pre: 1 to 18.
[[nodiscard]] const Law& law_of(int number);

// A law each: docs/laws.md has their exact statements.
[[nodiscard]] Finding finite_and_bounded(const LawCase& law_case);
[[nodiscard]] Finding no_step_of_its_own(const LawCase& law_case);
[[nodiscard]] Finding interface_makes_nothing(const LawCase& law_case);
[[nodiscard]] Finding limits_are_passive(const LawCase& law_case);
[[nodiscard]] Finding looking_changes_nothing(const LawCase& law_case);
[[nodiscard]] Finding order_and_frame_change_nothing(const LawCase& law_case);
[[nodiscard]] Finding units_change_nothing(const LawCase& law_case);
[[nodiscard]] Finding refinement_converges(const LawCase& law_case);
[[nodiscard]] Finding comes_to_rest(const LawCase& law_case);
[[nodiscard]] Finding stands(const LawCase& law_case);
[[nodiscard]] Finding nothing_tunnels(const LawCase& law_case);
[[nodiscard]] Finding keeps_its_deadline(const LawCase& law_case);
[[nodiscard]] Finding costs_are_linear(const LawCase& law_case);
[[nodiscard]] Finding verdict_is_the_worst(const LawCase& law_case);
[[nodiscard]] Finding every_vector_alike(const LawCase& law_case);
[[nodiscard]] Finding nothing_gains_energy(const LawCase& law_case);
[[nodiscard]] Finding one_simulation(const LawCase& law_case);
[[nodiscard]] Finding feels_solid(const LawCase& law_case);

}  // namespace stillgrid::laws
