#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <set>
#include <string>

#include "tests/model/publication_model.hpp"

namespace stillgrid::model {

/// What publication promises to each of its readers.
enum class Law {
  kWhole,      // all words of an accepted snapshot are of one publication
  kReported,   // of the one that stored the snapshot reported
  kForward,    // snapshots never go backwards
  kProgress,   // a failed attempt on n has seen the start of n + 2 or later, and the next attempt
               // is on n + 1 or later: two failed ones have outlived the start of two publications
  kQuiescent,  // once the writer is dead, a snapshot published is accepted at the first attempt
};
std::ostream& operator<<(std::ostream& out, Law law);

/// How far a check goes. All that can happen within is visited.
struct Bounds {
  std::uint64_t snapshots = 3;
  std::size_t payload_words = 2;
  int writers = 1;  // one after another, each killed before each of its steps in turn
  // Reads beside the last writer for each of its deaths, or only beside its whole life. The latter
  // finds the same for less, but its counterexamples are longer.
  bool has_reads_for_each_death = true;
  bool ends_with_first_broken = false;
};

/// What a check has found.
struct Findings {
  std::set<Law> broken;
  std::string counterexamples;   // one a law broken, as a trace
  std::uint64_t histories = 0;   // of the writers, each dead at another step
  std::uint64_t states = 0;      // of a reader between two reads
  std::uint64_t executions = 0;  // of a read
};

/// Visits all executions of any number of reads beside writers that may be killed at every step.
///
/// This is exact, although the reader runs after the writers. The reader never stores, so what the
/// writers store, and what each store's message carries, is the same with and without it. An
/// execution of both at once lets a load choose among the messages that are already there; the
/// same choices are possible later, when there are more. Conversely each choice made here is one
/// of an execution in which the writers were faster.
/// A state between two reads is what the reader knows and the snapshot it last accepted. From a
/// state seen before nothing new can follow, so the number of reads has no bound.
[[nodiscard]] Findings check_publication(const Mutant& mutant, const Bounds& bounds);

}  // namespace stillgrid::model
