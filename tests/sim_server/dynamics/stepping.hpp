#pragma once

#include <optional>

#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sanitizer_cut.hpp"

namespace stillgrid::dynamics {

using tests::kCut;

[[nodiscard]] inline std::optional<ToolSample> no_tool() {
  return std::nullopt;
}

/// Steps without a tool; whether every step converged.
[[nodiscard]] inline bool advance(Simulation& simulation, double step_s, int steps) {
  bool converged = true;
  for (int i = 0; i < steps; ++i)
    converged = simulation.step(step_s, no_tool).solve.converged && converged;
  return converged;
}

/// Energies at present, of contacts too. An account of the simulation begins anew.
[[nodiscard]] inline Energies energies_of(Simulation& simulation) {
  simulation.account_energy();
  return simulation.energy_account()->end;
}

}  // namespace stillgrid::dynamics
