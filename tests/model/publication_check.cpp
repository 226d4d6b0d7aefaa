#include "tests/model/publication_check.hpp"

#include <algorithm>
#include <limits>
#include <ostream>
#include <sstream>
#include <vector>

namespace stillgrid::model {
namespace {

constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();

/// A reader between two reads.
struct State {
  Reader reader;
  std::uint64_t accepted = 0;  // snapshot, 0: none yet

  auto operator<=>(const State&) const = default;  // NOLINT(modernize-use-nullptr): misled
};

/// A state, and by which read from which state it was reached first.
struct Visit {
  State state;
  std::size_t from;
  std::vector<ReaderStep> steps;
};

std::set<Law> laws_broken(const ReadRecord& read, std::uint64_t accepted_before) {
  std::set<Law> broken;
  const bool is_accepted = read.result.status == double_buffer::ReadStatus::kAccepted;
  if (is_accepted) {
    const auto all_are = [&](std::uint64_t publication) {
      return std::all_of(read.words.begin(), read.words.end(),
                         [&](std::uint64_t word) { return word == publication; });
    };
    if (!all_are(read.words.front())) broken.insert(Law::kWhole);
    if (!all_are(read.attempts.back().publication)) broken.insert(Law::kReported);
    if (read.result.snapshot_id < accepted_before) broken.insert(Law::kForward);
  }
  const std::size_t failed = read.attempts.size() - (is_accepted ? 1 : 0);
  for (std::size_t i = 0; i < failed; ++i) {
    const Attempt& attempt = read.attempts[i];
    if (attempt.sequence < 2 * (attempt.snapshot_id + 2) - 1) broken.insert(Law::kProgress);
    if (i + 1 < read.attempts.size() && read.attempts[i + 1].snapshot_id <= attempt.snapshot_id)
      broken.insert(Law::kProgress);
  }
  return broken;
}

class Check {
 public:
  Check(const Mutant& mutant, const Bounds& bounds) : mutant_(mutant), bounds_(bounds) {}

  /// All deaths of the writers after those whose deaths are given.
  void visit_histories(std::vector<std::size_t>& deaths) {
    const std::size_t steps = last_writer_steps(deaths, kNever);
    const bool is_last = deaths.size() + 1 == static_cast<std::size_t>(bounds_.writers);
    for (std::size_t death = 0; death <= steps && !has_ended(); ++death) {
      deaths.push_back(death);
      PublicationModel model = run(deaths);
      ++findings_.histories;
      check_quiescent(model);
      if (!is_last) visit_histories(deaths);
      if (is_last && (death == steps || bounds_.has_reads_for_each_death)) visit_reads(model);
      deaths.pop_back();
    }
  }

  Findings findings_;

 private:
  [[nodiscard]] PublicationModel run(const std::vector<std::size_t>& deaths) const {
    PublicationModel model(mutant_, bounds_.payload_words);
    for (const std::size_t death : deaths) model.write(bounds_.snapshots, death);
    return model;
  }

  [[nodiscard]] std::size_t last_writer_steps(const std::vector<std::size_t>& deaths,
                                              std::size_t death) const {
    return run(deaths).write(bounds_.snapshots, death);
  }

  void check_quiescent(PublicationModel& model) {
    Reader reader;
    Choices newest;
    const ReadRecord& read = model.read(reader, newest);
    const bool is_published = model.latest() > 0;
    const double_buffer::ReadStatus expected =
        is_published ? double_buffer::ReadStatus::kAccepted : double_buffer::ReadStatus::kEmpty;
    if (read.result.status != expected || read.result.snapshot_id != model.latest() ||
        read.result.attempts != (is_published ? 1 : 0))
      report(model, Law::kQuiescent, read.steps);
  }

  [[nodiscard]] bool has_ended() const {
    return bounds_.ends_with_first_broken && !findings_.broken.empty();
  }

  /// All reads that can follow one another in this history, breadth first.
  void visit_reads(PublicationModel& model) {
    std::set<State> seen{State{}};
    std::vector<Visit> visits{{State{}, 0, {}}};
    for (std::size_t next = 0; next < visits.size() && !has_ended(); ++next) {
      Choices choices;
      do {
        State state = visits[next].state;
        const ReadRecord& read = model.read(state.reader, choices);
        ++findings_.executions;
        for (const Law law : laws_broken(read, state.accepted))
          if (!findings_.broken.contains(law)) report(model, law, steps_to(visits, next, read));
        if (read.result.status == double_buffer::ReadStatus::kAccepted)
          state.accepted = read.result.snapshot_id;
        if (seen.insert(state).second) visits.push_back({state, next, read.steps});
      } while (choices.next());
    }
    findings_.states += visits.size();
  }

  static std::vector<ReaderStep> steps_to(const std::vector<Visit>& visits, std::size_t visit,
                                          const ReadRecord& read) {
    std::vector<ReaderStep> steps = read.steps;
    for (; visit != 0; visit = visits[visit].from)
      steps.insert(steps.begin(), visits[visit].steps.begin(), visits[visit].steps.end());
    return steps;
  }

  void report(const PublicationModel& model, Law law, const std::vector<ReaderStep>& steps) {
    if (!findings_.broken.insert(law).second) return;
    std::ostringstream text;
    text << "Broken: " << law << '\n' << model.trace(steps);
    findings_.counterexamples += text.str();
  }

  const Mutant& mutant_;
  const Bounds& bounds_;
};

}  // namespace

std::ostream& operator<<(std::ostream& out, Law law) {
  switch (law) {
    case Law::kWhole:
      return out << "a snapshot is whole";
    case Law::kReported:
      return out << "a snapshot is the one reported";
    case Law::kForward:
      return out << "snapshots never go backwards";
    case Law::kProgress:
      return out << "two attempts fail only when two publications began";
    case Law::kQuiescent:
      return out << "the snapshot of a dead writer is accepted at once";
  }
  return out;
}

Findings check_publication(const Mutant& mutant, const Bounds& bounds) {
  Check check(mutant, bounds);
  std::vector<std::size_t> deaths;
  check.visit_histories(deaths);
  return check.findings_;
}

}  // namespace stillgrid::model
