#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>

#include "shared/command_line/run_program.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/stop_signal.hpp"
#include "tests/soak/soak_report.hpp"

namespace stillgrid::soak {
namespace {

constexpr const char* kDescription =
    "A writer process and a reader process share a segment under load, and every word that a read\n"
    "was accepted with is judged.\n"
    "\n"
    "  publication_soak --publications 3000 --spacing-us 1000     ticks at 1 kHz read all words\n"
    "  publication_soak --publications 60000 --words 512          ... or 512, as a haptic tick "
    "does\n"
    "  publication_soak --publications 20000 --spacing-us 0       both at full speed\n"
    "  publication_soak --kills 30                                writers that are killed "
    "(SIGKILL)\n"
    "  publication_soak --publications 20000 --spacing-us 0 --without-last-check\n"
    "\n"
    "Laws: no read is torn (a word of another snapshot), mixed (words of two) or backwards. At "
    "a\n"
    "spacing every tick has something to show and 99 % are accepted; a killed writer leaves its "
    "last\n"
    "snapshot whole, no lock, and after an orderly end no file. Exit status 1 if a law is "
    "broken.\n";

struct Arguments {
  SoakPlan plan;
  std::optional<std::uint64_t> spacing_us;
  std::optional<std::size_t> words;
  std::filesystem::path report;
};

void add_options(CLI::App& app, Arguments& arguments) {
  SoakPlan& plan = arguments.plan;
  auto* const what = app.add_option_group("what");
  what->add_option("--publications", plan.publications, "Snapshots to publish")
      ->check(CLI::Range(1UL, 1'000'000'000UL));
  what->add_option("--kills", plan.kills, "Writers to kill, one after the other")
      ->check(CLI::Range(1UL, kMaxKills));
  what->require_option(1);
  app.add_option("--spacing-us", arguments.spacing_us,
                 "Time between publications, us; 0: full speed; default: 1000, or 0 with --kills")
      ->check(CLI::Range(0UL, 1'000'000UL));
  app.add_option("--bytes", plan.bytes, "Size of a snapshot, a multiple of 8; default: 1 MiB")
      ->default_val(std::size_t{1} << 20U)
      ->check(CLI::Range(64UL, 1UL << 28U));
  app.add_option(
         "--words", arguments.words,
         "Words that a tick gathers, strewn over the snapshot; 0: all; default: 0, or 512 with "
         "--kills, where all are read once more after each tick")
      ->check(CLI::Range(0UL, 1UL << 20U));
  app.add_option("--seed", plan.seed, "Of the instants of the kills; default: 1")->default_val(1);
  app.add_flag("--without-last-check", plan.skips_last_check,
               "Negative control: the reader skips its last check and must be seen to tear");
  app.add_option("--report", arguments.report, "Write the figures (JSON)");
}

int run(Arguments& arguments) {
  SoakPlan& plan = arguments.plan;
  if (plan.bytes % 8 != 0)
    throw CLI::ValidationError(
        "--bytes", "value " + std::to_string(plan.bytes) + ": expected a multiple of 8");
  plan.session = "soak-" + std::to_string(::getpid());
  plan.spacing_ns = 1000 * arguments.spacing_us.value_or(plan.kills > 0 ? 0 : 1000);
  plan.words_a_tick = arguments.words.value_or(plan.kills > 0 ? 512 : 0);
  const SharedSoakState state;
  std::optional<KillTally> kills;
  if (plan.kills > 0) kills.emplace();
  const std::uint64_t began_ns = realtime::monotonic_ns();
  const bool is_complete = kills ? run_kills(plan, *state, *kills) : run_publications(plan, *state);
  const double seconds = static_cast<double>(realtime::monotonic_ns() - began_ns) * 1e-9;
  const auto report = soak_report(plan, *state, kills, is_complete, seconds);
  print(report);
  if (!arguments.report.empty()) {
    std::ofstream out(arguments.report);
    out << report.dump(2) << '\n';
    out.close();
    if (!out) throw std::runtime_error(arguments.report.string() + ": cannot be written");
  }
  return report["broken_laws"].empty() ? realtime::kDone : realtime::kBadInput;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "publication_soak");
  Arguments arguments;
  add_options(app, arguments);
  return command_line::run_program(app, argc, argv, [&] {
    realtime::install_stop_signal();
    return run(arguments);
  });
}

}  // namespace
}  // namespace stillgrid::soak

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::soak::program_main(argc, argv);
}
