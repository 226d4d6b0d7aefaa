// Laws that hold in every scene: draws scenes, checks, shrinks what breaks a law, replays the
// corpus.

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "shared/command_line/run_program.hpp"
#include "tests/laws/corpus.hpp"
#include "tests/laws/generator.hpp"
#include "tests/laws/known.hpp"
#include "tests/laws/shrink.hpp"
#include "tests/laws/tried.hpp"

namespace stillgrid::laws {
namespace {

constexpr int kViolated = 3;

constexpr const char* kDescription =
    "Laws that hold in every scene (docs/laws.md), in virtual time.\n"
    "\n"
    "  laws --law 2 --seeds 1:101            a hundred drawn scenes\n"
    "  laws --law 2 --seeds 17:18 --shrink   the smallest scene that still breaks the law\n"
    "  laws --case FILE.toml                 one case again\n"
    "  laws --corpus tests/laws/corpus       every kept case\n"
    "  laws --short                          some seconds of every law\n"
    "\n"
    "Exit status 0: all as expected; 3: a law is violated that is not known to be, or what is\n"
    "listed as failing holds; 1: bad input.\n";

struct Arguments {
  std::vector<int> laws;
  std::string seeds;
  std::filesystem::path file, corpus;
  bool short_run = false, list = false, json = false, shrink = false, print = false;
};

struct Count {
  std::array<std::uint64_t, kOutcomes> of_outcome{};
  std::map<std::string, std::uint64_t> known;    // violated, by step
  std::map<std::string, std::uint64_t> covered;  // tried among those known, by step
  std::uint64_t tried = 0;
};

std::pair<std::uint64_t, std::uint64_t> seeds_of(const std::string& text) {
  const auto colon = text.find(':');
  const auto number = [&text](const std::string& digits) {
    if (digits.empty() || digits.find_first_not_of("0123456789") != std::string::npos ||
        digits.size() > 18)
      throw std::runtime_error("--seeds '" + text + "': expected FIRST:END, whole numbers");
    return std::stoull(digits);
  };
  if (colon == std::string::npos) return {number(text), number(text) + 1};
  return {number(text.substr(0, colon)), number(text.substr(colon + 1))};
}

void show_shrunk(const LawCase& law_case, int tries) {
  const LawCase shrunk = shrink(law_case, tries);
  const Tried tried = try_case(shrunk);
  std::cout << "# " << line_of(shrunk, tried) << "\n" << print_case(shrunk) << std::flush;
}

void note(const LawCase& law_case, const Tried& tried, bool shrinks, Count& count) {
  ++count.tried;
  ++count.of_outcome[static_cast<std::size_t>(tried.outcome)];
  if (const auto step = known_violation(law_case)) {
    ++count.covered[std::string(*step)];
    if (tried.outcome == Outcome::kKnown) ++count.known[std::string(*step)];
  }
  const bool is_shown = tried.outcome == Outcome::kViolated || tried.outcome == Outcome::kTooLong ||
                        (shrinks && tried.outcome == Outcome::kKnown);
  if (!is_shown) return;
  std::cout << line_of(law_case, tried) << " | laws --law " << law_case.law << " --seeds "
            << law_case.seed << ":" << law_case.seed + 1 << std::endl;
  if (shrinks && tried.outcome != Outcome::kTooLong) show_shrunk(law_case, 400);
}

void show_count(int law, const Count& count, bool as_json) {
  const auto of = [&count](Outcome outcome) {
    return count.of_outcome[static_cast<std::size_t>(outcome)];
  };
  if (as_json) {
    std::cout << nlohmann::json{{"law", law},
                                {"tried", count.tried},
                                {"holds", of(Outcome::kHolds)},
                                {"violated", of(Outcome::kViolated)},
                                {"known", count.known},
                                {"covered", count.covered},
                                {"not_spoken_of", of(Outcome::kNotSpokenOf)},
                                {"too_long", of(Outcome::kTooLong)},
                                {"no_data", of(Outcome::kNoData)}}
              << std::endl;
    return;
  }
  std::printf("law %2d %-26s %6llu tried, %llu violated, %llu as known, %llu not spoken of\n", law,
              std::string(law_of(law).name).c_str(), static_cast<unsigned long long>(count.tried),
              static_cast<unsigned long long>(of(Outcome::kViolated)),
              static_cast<unsigned long long>(of(Outcome::kKnown)),
              static_cast<unsigned long long>(of(Outcome::kNotSpokenOf)));
  std::fflush(stdout);
}

/// Whether all were as expected.
bool run_law(int law, std::uint64_t first, std::uint64_t end, const Arguments& arguments) {
  Count count;
  for (std::uint64_t seed = first; seed < end; ++seed) {
    const LawCase law_case = draw_case(law, seed);
    if (arguments.print) {
      std::cout << print_case(law_case);
      continue;
    }
    note(law_case, try_case(law_case), arguments.shrink, count);
  }
  if (!arguments.print) show_count(law, count, arguments.json);
  return count.of_outcome[static_cast<std::size_t>(Outcome::kViolated)] == 0;
}

int run_case(const Arguments& arguments) {
  const LawCase law_case = load_case(arguments.file);
  if (arguments.shrink) {
    show_shrunk(law_case, 400);
    return realtime::kDone;
  }
  const Tried tried = try_case(law_case);
  std::cout << line_of(law_case, tried) << '\n';
  return tried.finding.holds() ? realtime::kDone : kViolated;
}

int run(const Arguments& arguments) {
  if (arguments.list) {
    for (const Law& law : all_laws())
      std::cout << law.number << ' ' << law.name << ": " << law.statement << '\n';
    return realtime::kDone;
  }
  if (!arguments.file.empty()) return run_case(arguments);
  bool as_expected = true;
  if (!arguments.corpus.empty()) as_expected = replay_corpus(arguments.corpus) && as_expected;
  if (arguments.short_run)
    for (const Law& law : all_laws())
      as_expected =
          run_law(law.number, 1, 1 + static_cast<std::uint64_t>(law.short_seeds), arguments) &&
          as_expected;
  if (!arguments.laws.empty()) {
    const auto [first, end] = seeds_of(arguments.seeds);
    for (const int law : arguments.laws)
      as_expected = run_law(law, first, end, arguments) && as_expected;
  }
  if (arguments.corpus.empty() && !arguments.short_run && arguments.laws.empty())
    throw std::runtime_error("expected --law, --case, --corpus, --short or --list: see --help");
  return as_expected ? realtime::kDone : kViolated;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "laws");
  Arguments arguments;
  app.add_option("--law", arguments.laws, "1 to 18, one or more")->check(CLI::Range(1, 18));
  arguments.seeds = "1:101";
  app.add_option("--seeds", arguments.seeds, "FIRST:END or one; default 1:101");
  app.add_option("--case", arguments.file, "A file of the corpus, or one that --shrink printed");
  app.add_option("--corpus", arguments.corpus, "Every case of a folder");
  app.add_flag("--short", arguments.short_run, "A few seeds of every law");
  app.add_flag("--shrink", arguments.shrink, "Print the smallest scene that breaks the law");
  app.add_flag("--print", arguments.print, "Print the drawn cases, check nothing");
  app.add_flag("--list", arguments.list, "The laws");
  app.add_flag("--json", arguments.json, "Counts as JSON, a line a law");
  return command_line::run_program(app, argc, argv, [&] { return run(arguments); });
}

}  // namespace
}  // namespace stillgrid::laws

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::laws::program_main(argc, argv);
}
