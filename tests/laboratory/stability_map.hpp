#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/laboratory/lab_cell.hpp"

namespace stillgrid::laboratory {

/// A map of the largest stable stiffness: every combination of what is listed.
struct StabilityMap {
  LabCell common;  // the rest of each cell
  std::vector<std::string> scenes = {"wall"}, tools = {"1x1"}, devices = {"light"},
                           limits = {"none"}, froms = {"inside"}, transitions = {"local"},
                           models = {"grid"};
  std::vector<double> periods_s = {0.01}, latency_shares = {0.0}, jitters = {0.0};
};

/// The cells of a map, the last list running fastest. Models other than grid have no transition
/// and come once, with the first; what only the tool holds is not come to from outside.
[[nodiscard]] std::vector<LabCell> cells_of(const StabilityMap& map);

/// Measures the cells in so many threads and writes a row of each, in their order, with what was
/// searched and found: docs/algorithms/stability.md has the columns. Rows of a file that is there
/// are kept and not measured again, and each new one is added as it comes: a map that was stopped
/// goes on. A stop signal ends it after the cells at hand. Says on standard error how far it is and
/// what is left, by what cells took. Throws std::runtime_error.
void draw_map(const StabilityMap& map, const StiffnessSearch& search, unsigned threads,
              const std::filesystem::path& file);

}  // namespace stillgrid::laboratory
