// Prints what the interface makes in the drawn scenes of law 3, by each transition: a table.

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#include "tests/laws/generator.hpp"

namespace stillgrid::laws {
namespace {

constexpr int kLaw = 3;

/// The most that the hand had given the scene, of all ticks.
double put_in_J(const laboratory::LabRun& run) {
  double given_J = 0.0, most_J = 0.0;
  for (std::size_t i = 1; i < run.rows.size(); ++i) {
    given_J -= run.rows[i - 1].rendered_N.dot(run.rows[i].position_m - run.rows[i - 1].position_m);
    most_J = std::max(most_J, given_J);
  }
  return most_J;
}

void print_rows(std::uint64_t seed) {
  LawCase law_case = draw_case(kLaw, seed);
  const scene::SceneDescription scene = scene_of(law_case);
  for (const display::TransitionLaw& law : display::transitions()) {
    law_case.transition = law.name;
    const CaseLoop loop = loop_of(law_case, scene);
    const laboratory::LabRun run = laboratory::run_lab(scene, loop.options);
    const auto& account = run.report.interface;
    if (!account || !account->most_made_in_a_second_J)
      throw std::runtime_error("seed " + std::to_string(seed) + ": no account of a second");
    std::printf("%llu,%s,%.4g,%.3g,%.3g,%.4g,%.4g,%.4g\n", static_cast<unsigned long long>(seed),
                std::string(law.name).c_str(), 1.0 / scene.period_s, law_case.latency_share,
                law_case.jitter, *account->most_made_in_a_second_J, account->made_J, put_in_J(run));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace stillgrid::laws

int main(int argc, char** argv) {
  const bool is_small = argc > 1 && std::strcmp(argv[1], "--small") == 0;
  std::puts("seed,transition,rate_hz,latency_share,jitter,most_made_in_a_second_J,made_J,put_in_J");
  try {
    for (std::uint64_t seed = 1; seed <= (is_small ? 20U : 200U); ++seed)
      stillgrid::laws::print_rows(seed);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "interface_figures: %s\n", error.what());
    return 1;
  }
  return 0;
}
