#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace stillgrid::spheres {

/// Chooses few of many sets that together hold every element: sets are numbered in the order in
/// which they are added, elements likewise.
///
/// Greedy first, then the weighted local search of [Gao, Weise and Li, An efficient local search
/// heuristic with row weighting for the unicost set covering problem, EJOR 246, 2015]. A seeded
/// generator decides ties: the same calls give the same choice.
class SetCover {
 public:
  /// Adds a set that holds these elements; they must have been added before.
  void add_set(std::vector<std::uint32_t> elements);

  /// Adds an element that these sets hold; they must have been added before. False, and nothing is
  /// added, if none of them is left.
  bool add_element(std::vector<std::uint32_t> sets);

  /// Takes a set out for good. Returns the elements that are in no set any more: add_set() must
  /// mend that, or forget_lost().
  std::vector<std::uint32_t> forbid(std::uint32_t set);

  /// Asks no more for an element that is in no set; otherwise does nothing.
  void forget_lost(std::uint32_t element);

  /// Adds sets, the one with the most uncovered elements first, until all are covered.
  /// Pre: each element is in a set.
  void cover_greedily();

  /// Looks for fewer sets for as long as that costs about `max_visits` visits of an element or a
  /// set. Pre: as cover_greedily().
  void improve(std::uint64_t max_visits);

  [[nodiscard]] std::vector<std::uint32_t> chosen() const;  // ascending
  [[nodiscard]] std::size_t sets() const { return elements_of_.size(); }
  [[nodiscard]] std::size_t elements() const { return sets_of_.size(); }

 private:
  void put(std::uint32_t set);
  void take(std::uint32_t set);
  void drop_spare();
  [[nodiscard]] std::uint32_t cheapest(std::uint32_t tabu) const;

  std::vector<std::vector<std::uint32_t>> elements_of_, sets_of_;
  std::vector<std::uint32_t> covers_;           // of an element, how many chosen sets hold it
  std::vector<std::int64_t> weights_;           // of an element
  std::vector<std::int64_t> scores_;            // weight lost without, or won with, a set
  std::vector<char> is_chosen_, is_forbidden_;  // of a set
  std::vector<std::uint64_t> changed_at_;       // of a set, the step
  std::vector<std::uint32_t> chosen_, place_of_set_;
  std::vector<std::uint32_t> uncovered_, place_of_element_;
  std::uint64_t step_ = 0, visits_ = 0;
  std::mt19937_64 random_{1};
};

}  // namespace stillgrid::spheres
