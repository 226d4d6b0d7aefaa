#include "tests/laws/corpus.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "tests/laws/tried.hpp"

namespace stillgrid::laws {

bool replay_corpus(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  if (files.empty()) throw std::runtime_error(folder.string() + ": expected cases, FILE.toml");
  std::sort(files.begin(), files.end());
  bool all = true;
  for (const std::filesystem::path& file : files) {
    const LawCase law_case = load_case(file);
    const Tried tried = try_case(law_case);
    const bool is_listed = !law_case.until.empty();
    const bool has_figure = std::isfinite(tried.finding.measured);  // no crash, nothing thrown
    const bool expected =
        tried.outcome == Outcome::kNoData ||
        (tried.finding.applies && has_figure && tried.finding.holds() != is_listed);
    all = all && expected;
    std::cout << file.stem().string() << ": " << (expected ? "as expected: " : "UNEXPECTED: ")
              << line_of(law_case, tried)
              << (is_listed ? ", listed until " + law_case.until : std::string()) << std::endl;
  }
  return all;
}

}  // namespace stillgrid::laws
