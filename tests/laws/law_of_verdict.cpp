// The law of verdicts: a stability limit is the worst of many seeds.

#include <algorithm>
#include <string>

#include "tests/laboratory/lab_cell.hpp"
#include "tests/laws/law.hpp"

namespace stillgrid::laws {

Finding verdict_is_the_worst(const LawCase& law_case) {
  constexpr int kSeeds = 8;
  const scene::SceneDescription scene = scene_of(law_case);
  CaseLoop loop = loop_of(law_case, scene);
  const auto limit_N_per_m = [&](std::uint64_t seed) {
    const auto is_stable = [&](double stiffness_N_per_m) {
      scene::SceneDescription stiff = scene;
      stiff.materials.front().contact_stiffness_N_per_m = stiffness_N_per_m;
      laboratory::LabOptions options = loop.options;
      options.seed = seed;
      return laboratory::verdict_of(laboratory::run_lab(stiff, options).rows, {.window_s = 0.5}) ==
             laboratory::Verdict::kStable;
    };
    return laboratory::largest_stable_stiffness_N_per_m(
               is_stable, {.lowest_N_per_m = 100.0, .highest_N_per_m = 10'000.0})
        .value_or(0.0);
  };
  // What `stability_lab limit` prints.
  const double verdict_N_per_m = limit_N_per_m(law_case.seed);
  double worst_N_per_m = verdict_N_per_m;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed)
    worst_N_per_m = std::min(worst_N_per_m, limit_N_per_m(law_case.seed + seed));
  constexpr double kStride = 1.22;  // of the search
  return {.measured = verdict_N_per_m,
          .allowed = kStride * worst_N_per_m,
          .what = "N/m borne by the verdict; allowed: a stride over the worst of " +
                  std::to_string(kSeeds) + " seeds"};
}

}  // namespace stillgrid::laws
