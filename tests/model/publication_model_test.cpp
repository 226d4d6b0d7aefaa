#include <bitset>
#include <catch2/catch.hpp>
#include <chrono>
#include <initializer_list>
#include <iostream>
#include <iterator>
#include <set>

#include "tests/model/publication_check.hpp"

namespace stillgrid::model::publication_model_test {
namespace {

using Laws = std::set<Law>;
const Laws kNone;
const Laws kTorn{Law::kWhole, Law::kReported};

Mutant relaxed(std::initializer_list<Step> steps) {
  Mutant mutant;
  for (const Step step : steps) mutant.relaxed.set(static_cast<std::size_t>(step));
  return mutant;
}

/// The counterexamples are shown when a check fails, or always with the option -s.
Laws broken_by(const Mutant& mutant, int writers) {
  const Findings findings = check_publication(mutant, {.writers = writers});
  UNSCOPED_INFO(findings.counterexamples);
  return findings.broken;
}

/// Each writer in a memory of its own, as in our segments.
Laws broken_in_fresh_memory(const Mutant& mutant) {
  return broken_by(mutant, 1);
}

/// A second writer goes on in the memory of the first, killed anywhere.
Laws broken_with_successor(const Mutant& mutant) {
  return broken_by(mutant, 2);
}

/// All laws hold within these bounds, and the check was not vacuous.
void check_within(Bounds bounds, std::uint64_t least_executions) {
  bounds.ends_with_first_broken = true;
  const auto begin = std::chrono::steady_clock::now();
  const Findings findings = check_publication({}, bounds);
  const std::chrono::duration<double> elapsed_s = std::chrono::steady_clock::now() - begin;
  INFO(findings.counterexamples);
  REQUIRE(findings.broken == kNone);
  CHECK(findings.executions >= least_executions);
  std::cout << "model: " << bounds.snapshots << " snapshots, " << bounds.payload_words << " words, "
            << bounds.writers << " writers: " << findings.histories << " histories, "
            << findings.states << " states, " << findings.executions << " reads, "
            << elapsed_s.count() << " s\n"
            << std::flush;
}

TEST_CASE("Publication keeps its laws whatever its readers may see", "[model]") {
  check_within({.snapshots = 8, .payload_words = 2, .writers = 1}, 300'000);
}

TEST_CASE("Publication keeps its laws when writers follow one another in the same memory",
          "[model]") {
  check_within({.snapshots = 5, .payload_words = 2, .writers = 2}, 300'000);
  check_within({.snapshots = 4, .payload_words = 2, .writers = 3}, 1'000'000);
  check_within({.snapshots = 3, .payload_words = 1, .writers = 4}, 100'000);
}

TEST_CASE("Publication keeps its laws over many snapshots, words and writers", "[.long]") {
  check_within({.snapshots = 12, .payload_words = 2, .writers = 1}, 1'000'000);
  check_within({.snapshots = 8, .payload_words = 2, .writers = 2}, 10'000'000);
  check_within({.snapshots = 6, .payload_words = 3, .writers = 2}, 5'000'000);
  check_within({.snapshots = 5, .payload_words = 3, .writers = 3}, 10'000'000);
  check_within({.snapshots = 4, .payload_words = 2, .writers = 4}, 10'000'000);
}

TEST_CASE("Without the fence W2 a reader accepts a torn snapshot", "[model]") {
  CHECK(broken_in_fresh_memory(relaxed({Step::kW2})) == kTorn);
}

TEST_CASE("Without the fence R4 a reader accepts a torn snapshot", "[model]") {
  CHECK(broken_in_fresh_memory(relaxed({Step::kR4})) == kTorn);
}

TEST_CASE("Without the odd mark W1 a reader accepts a torn snapshot", "[model]") {
  CHECK(broken_in_fresh_memory({.has_odd_mark = false}) == kTorn);
}

TEST_CASE("With W4 and W5 both relaxed a reader accepts words not yet written", "[model]") {
  const Laws broken = broken_in_fresh_memory(relaxed({Step::kW4, Step::kW5}));
  CHECK(broken == Laws{Law::kWhole, Law::kReported, Law::kProgress});
}

TEST_CASE("With R1 and R2 both relaxed a reader accepts words not yet written", "[model]") {
  const Laws broken = broken_in_fresh_memory(relaxed({Step::kR1, Step::kR2}));
  CHECK(broken == Laws{Law::kWhole, Law::kReported, Law::kProgress});
}

TEST_CASE("In a single slot a writer that dies leaves nothing to read", "[model]") {
  const Laws broken = broken_in_fresh_memory({.has_two_slots = false});
  CHECK(broken == Laws{Law::kProgress, Law::kQuiescent});
}

TEST_CASE("A reader that asks latest instead of the sequence fails for one publication",
          "[model]") {
  CHECK(broken_in_fresh_memory({.checks_sequence = false}) == Laws{Law::kProgress});
}

TEST_CASE("With W1 or R5 relaxed both attempts fail for one publication, no snapshot is torn",
          "[model]") {
  const Step step = GENERATE(Step::kW1, Step::kR5);
  CHECK(broken_in_fresh_memory(relaxed({step})) == Laws{Law::kProgress});
  CHECK(broken_with_successor(relaxed({step})) == Laws{Law::kProgress});
}

TEST_CASE("With W5, R1 or R2 relaxed attempts fail for nothing, no snapshot is torn", "[model]") {
  const Step step = GENERATE(Step::kW5, Step::kR1, Step::kR2);
  CHECK(broken_in_fresh_memory(relaxed({step})) == Laws{Law::kProgress});
}

TEST_CASE("With R1 relaxed a reader mixes a dead writer with its successor in the same memory",
          "[model]") {
  const Laws broken = broken_with_successor(relaxed({Step::kR1}));
  CHECK(broken == Laws{Law::kWhole, Law::kReported, Law::kProgress});
}

TEST_CASE("W4 alone may be relaxed, for W5 releases the snapshot too", "[model]") {
  CHECK(broken_in_fresh_memory(relaxed({Step::kW4})) == kNone);
  CHECK(broken_with_successor(relaxed({Step::kW4})) == kNone);
}

TEST_CASE("A successor that counts afresh in the same memory breaks every law", "[model]") {
  CHECK(broken_with_successor({.successor_counts_afresh = true}) ==
        Laws{Law::kWhole, Law::kReported, Law::kForward, Law::kProgress, Law::kQuiescent});
}

constexpr Step kOrdered[] = {Step::kW1, Step::kW2, Step::kW4, Step::kW5,
                             Step::kR1, Step::kR2, Step::kR4, Step::kR5};

/// The laws that a protocol must break whose steps `kept` have their orders and the others none.
Laws expected_broken(const std::set<Step>& kept, bool has_successor) {
  const auto has = [&](Step step) { return kept.contains(step); };
  const bool snapshots_pass =
      (has(Step::kW4) && has(Step::kR2)) || (has(Step::kW5) && has(Step::kR1));
  const bool writers_differ = !has_successor || has(Step::kR1);
  Laws broken;
  if (!snapshots_pass || !has(Step::kW2) || !has(Step::kR4) || !writers_differ)
    broken.insert(Law::kReported);
  const bool end_passes_latest = has(Step::kW4) || has(Step::kW2);
  if (!has(Step::kW1) || !has(Step::kW5) || !has(Step::kR1) || !has(Step::kR2) || !has(Step::kR5) ||
      !end_passes_latest)
    broken.insert(Law::kProgress);
  return broken;
}

TEST_CASE("It is known of each set of weakened steps which laws it breaks", "[model]") {
  const bool has_successor = GENERATE(false, true);
  for (unsigned set = 0; set < 1U << std::size(kOrdered); ++set) {
    std::set<Step> kept;
    Mutant mutant;
    for (std::size_t i = 0; i < std::size(kOrdered); ++i) {
      if ((set >> i & 1U) != 0) {
        mutant.relaxed.set(static_cast<std::size_t>(kOrdered[i]));
      } else {
        kept.insert(kOrdered[i]);
      }
    }
    INFO("relaxed: " << mutant.relaxed << ", bit 0 is W1, bit 9 is R5");
    // A snapshot of one word cannot be torn, but shows a wrong word at an eighth of the cost.
    const Findings findings = check_publication(
        mutant,
        {.payload_words = 1, .writers = has_successor ? 2 : 1, .has_reads_for_each_death = false});
    INFO(findings.counterexamples);
    CHECK(findings.broken == expected_broken(kept, has_successor));
  }
}

}  // namespace
}  // namespace stillgrid::model::publication_model_test
