#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace stillgrid::choice {

/// One candidate of a choice, its cost and the error of its force.
struct Record {
  std::string name = {};                   // in words
  double work_per_ms = 0.0;                // counted work of a simulated millisecond
  std::optional<double> error_share = {};  // rms of the force's error over the true force's rms
  double truth_error_share = 0.0;          // the same of the truth beside one of half its step
  double latency_share = 0.0;  // lateness of snapshots in the run, in periods, by counted work
  std::size_t spheres = 0;     // or bricks of a contact's field
  double bytes = 0.0;          // published for a contact
  std::string refusal = {};    // why the candidate was not chosen; empty: chosen
};

/// Works that differ by less are equal: weights of counts are no more exact.
inline constexpr double kEqualWork = 1.1;

/// Chooses one record and writes why into the others. Returns its index.
///
/// Records that have a refusal already could not run. Among the others the cheapest is chosen that
/// keeps the error; of equal work the smallest. A record of as few bytes, of a work up to
/// kEqualWork times as large, takes its place if its error is smaller. If no record keeps the
/// error the most accurate is chosen, or the first if all errors are unknown. Pre: not empty.
std::size_t choose_record(std::span<Record> records, double max_error_share);

[[nodiscard]] bool keeps_error(const Record& record, double max_error_share);

/// Returns the record as one line of JSON, without its end.
[[nodiscard]] std::string json_line(const Record& record);

/// Returns a table for people: a line for each record, the chosen one with a star.
/// work_per_processor_ms: counted work of one processor in a millisecond.
[[nodiscard]] std::string table_of(std::span<const Record> records, double work_per_processor_ms);

}  // namespace stillgrid::choice
