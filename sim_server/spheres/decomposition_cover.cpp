#include "sim_server/spheres/decomposition_cover.hpp"

#include <algorithm>
#include <cassert>
#include <queue>
#include <utility>

#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::spheres {
namespace {

constexpr std::uint32_t kNowhere = ~0U;

/// A list whose members know their place in it.
void insert(std::vector<std::uint32_t>& list, std::vector<std::uint32_t>& places,
            std::uint32_t member) {
  places[member] = static_cast<std::uint32_t>(list.size());
  list.push_back(member);
}

void erase(std::vector<std::uint32_t>& list, std::vector<std::uint32_t>& places,
           std::uint32_t member) {
  const std::uint32_t last = list.back();
  list[places[member]] = last;
  places[last] = places[member];
  places[member] = kNowhere;
  list.pop_back();
}

}  // namespace

void SetCover::add_set(std::vector<std::uint32_t> elements) {
  const auto set = static_cast<std::uint32_t>(elements_of_.size());
  std::int64_t score = 0;
  for (const std::uint32_t element : elements) {
    sets_of_[element].push_back(set);
    if (covers_[element] == 0) score += weights_[element];
  }
  elements_of_.push_back(std::move(elements));
  scores_.push_back(score);
  is_chosen_.push_back(0);
  is_forbidden_.push_back(0);
  changed_at_.push_back(0);
  place_of_set_.push_back(kNowhere);
}

bool SetCover::add_element(std::vector<std::uint32_t> sets) {
  const auto element = static_cast<std::uint32_t>(sets_of_.size());
  std::erase_if(sets, [&](std::uint32_t set) { return is_forbidden_[set] != 0; });
  if (sets.empty()) return false;
  std::uint32_t covers = 0;
  for (const std::uint32_t set : sets) covers += is_chosen_[set] ? 1U : 0U;
  for (const std::uint32_t set : sets) {
    elements_of_[set].push_back(element);
    if (covers == 0 || (covers == 1 && is_chosen_[set])) ++scores_[set];
  }
  covers_.push_back(covers);
  weights_.push_back(1);
  place_of_element_.push_back(kNowhere);
  if (covers == 0) insert(uncovered_, place_of_element_, element);
  sets_of_.push_back(std::move(sets));
  return true;
}

std::vector<std::uint32_t> SetCover::forbid(std::uint32_t set) {
  if (is_chosen_[set]) take(set);
  std::vector<std::uint32_t> orphans;
  for (const std::uint32_t element : elements_of_[set]) {
    std::erase(sets_of_[element], set);
    if (sets_of_[element].empty()) orphans.push_back(element);
  }
  elements_of_[set].clear();
  scores_[set] = 0;
  is_forbidden_[set] = 1;
  return orphans;
}

void SetCover::forget_lost(std::uint32_t element) {
  if (!sets_of_[element].empty() || covers_[element] > 0) return;
  erase(uncovered_, place_of_element_, element);
  covers_[element] = 1;  // for good: no set will change it
}

void SetCover::put(std::uint32_t set) {
  is_chosen_[set] = 1;
  changed_at_[set] = step_;
  insert(chosen_, place_of_set_, set);
  scores_[set] = 0;
  for (const std::uint32_t element : elements_of_[set]) {
    const std::uint32_t covers = ++covers_[element];
    if (covers == 1) {
      scores_[set] += weights_[element];
      for (const std::uint32_t other : sets_of_[element])
        if (other != set) scores_[other] -= weights_[element];
      visits_ += sets_of_[element].size();
      erase(uncovered_, place_of_element_, element);
    } else if (covers == 2) {
      for (const std::uint32_t other : sets_of_[element]) {
        ++visits_;
        if (other == set || !is_chosen_[other]) continue;
        scores_[other] -= weights_[element];
        break;
      }
    }
  }
  visits_ += elements_of_[set].size();
}

void SetCover::take(std::uint32_t set) {
  is_chosen_[set] = 0;
  changed_at_[set] = step_;
  erase(chosen_, place_of_set_, set);
  scores_[set] = 0;
  for (const std::uint32_t element : elements_of_[set]) {
    const std::uint32_t covers = --covers_[element];
    if (covers == 0) {
      scores_[set] += weights_[element];
      for (const std::uint32_t other : sets_of_[element])
        if (other != set) scores_[other] += weights_[element];
      visits_ += sets_of_[element].size();
      insert(uncovered_, place_of_element_, element);
    } else if (covers == 1) {
      for (const std::uint32_t other : sets_of_[element]) {
        ++visits_;
        if (!is_chosen_[other]) continue;
        scores_[other] += weights_[element];
        break;
      }
    }
  }
  visits_ += elements_of_[set].size();
}

void SetCover::cover_greedily() {
  // A set's gain only falls while others are added: the first that is still what it was is best.
  std::priority_queue<std::pair<std::int64_t, std::uint32_t>> gains;
  const auto key = [](std::uint32_t set) { return ~set; };  // of equal gains the first set
  const auto gain = [&](std::uint32_t set) {
    std::int64_t count = 0;
    for (const std::uint32_t element : elements_of_[set]) count += covers_[element] == 0 ? 1 : 0;
    return count;
  };
  for (std::uint32_t set = 0; set < sets(); ++set)
    if (!is_chosen_[set] && !is_forbidden_[set]) gains.emplace(gain(set), key(set));
  while (!uncovered_.empty()) {
    realtime::throw_if_stopped();
    assert(!gains.empty());
    const auto [known, code] = gains.top();
    gains.pop();
    const std::uint32_t set = ~code;
    const std::int64_t now = gain(set);
    if (now < known) {
      if (now > 0) gains.emplace(now, code);
    } else {
      put(set);
    }
  }
}

std::uint32_t SetCover::cheapest(std::uint32_t tabu) const {
  std::uint32_t best = kNowhere;
  for (const std::uint32_t set : chosen_) {
    if (set == tabu) continue;
    if (best == kNowhere ||
        std::pair(scores_[set], changed_at_[set]) < std::pair(scores_[best], changed_at_[best]))
      best = set;
  }
  return best;
}

void SetCover::drop_spare() {
  while (chosen_.size() > 1) {
    const std::uint32_t set = cheapest(kNowhere);
    if (scores_[set] > 0) return;
    take(set);
  }
}

void SetCover::improve(std::uint64_t max_visits) {
  drop_spare();
  std::vector<std::uint32_t> best = chosen();
  std::uint32_t last = kNowhere;
  visits_ = 0;
  while (visits_ < max_visits && chosen_.size() > 1) {
    realtime::throw_if_stopped();
    ++step_;
    visits_ += 2 * chosen_.size();
    if (uncovered_.empty()) {
      drop_spare();
      if (chosen_.size() < best.size()) best = chosen();
      if (chosen_.size() == 1) break;
      take(cheapest(kNowhere));
      continue;
    }
    const std::uint32_t out = cheapest(last);
    if (out != kNowhere) take(out);
    const std::uint32_t element = uncovered_[random_() % uncovered_.size()];
    std::uint32_t in = kNowhere;
    for (const std::uint32_t set : sets_of_[element]) {
      // What has just been taken out comes back only where nothing else helps.
      if (set == out && sets_of_[element].size() > 1) continue;
      if (in == kNowhere || scores_[set] > scores_[in] ||
          (scores_[set] == scores_[in] && changed_at_[set] < changed_at_[in]))
        in = set;
    }
    visits_ += sets_of_[element].size();
    put(in);
    last = in;
    for (const std::uint32_t left : uncovered_) {
      ++weights_[left];
      for (const std::uint32_t set : sets_of_[left]) ++scores_[set];
      visits_ += sets_of_[left].size();
    }
  }
  if (uncovered_.empty()) {
    drop_spare();
    if (chosen_.size() <= best.size()) return;
  }
  for (const std::uint32_t set : chosen())
    if (!std::binary_search(best.begin(), best.end(), set)) take(set);
  for (const std::uint32_t set : best)
    if (!is_chosen_[set]) put(set);
}

std::vector<std::uint32_t> SetCover::chosen() const {
  std::vector<std::uint32_t> sets = chosen_;
  std::sort(sets.begin(), sets.end());
  return sets;
}

}  // namespace stillgrid::spheres
