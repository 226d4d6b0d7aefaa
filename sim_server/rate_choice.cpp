#include "sim_server/rate_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "shared/rendering/force_error.hpp"

namespace stillgrid::sim_server {
namespace {

constexpr std::array kRates_hz = {1000.0, 500.0, 330.0, 200.0, 125.0, 80.0,
                                  50.0,   33.0,  20.0,  14.0,  10.0};
constexpr int kRuns = 8;
constexpr double kReferenceShare = 0.4;  // of the budget, for coming to rest and the reference
constexpr double kRateShare = 0.7;       // of the period, for 19 of 20 steps
constexpr double kLateFrom = 0.05;       // of the period: faster steps are not felt to be late

/// What all runs have in common.
struct Trials {
  const scene::SceneDescription& scene;
  const HandPath& hand;
  const CostClock& now_s;
  TrueForce truth;
  double end_s;  // of the budget

  /// Runs a rate once more, if the budget allows; false: it does not.
  [[nodiscard]] bool run(RateTrial& trial) const {
    scene::SceneDescription at_rate = scene;
    at_rate.period_s = 1.0 / trial.rate_hz;
    FeltOptions options{.first_share = 1.0 - static_cast<double>(trial.runs) / kRuns,
                        .duration_s = 1e-3 * static_cast<double>(truth.felt.force_N.size()),
                        .deadline_s = end_s};
    FeltForce felt = felt_force(at_rate, truth.start, hand, options, now_s);
    if (felt.failure.empty() && felt.slow_step_share >= kLateFrom && felt.slow_step_share <= 1.0) {
      options.latency_s = std::ceil(10.0 * felt.slow_step_share) / 10.0 * at_rate.period_s;
      felt = felt_force(at_rate, truth.start, hand, options, now_s);
    }
    if (felt.failure == "out of time") {
      if (trial.runs == 0) trial.refusal = "not tried: out of time";
      return false;
    }
    ++trial.runs;
    trial.processor_share = std::max(trial.processor_share.value_or(0.0), felt.processor_share);
    if (felt.slow_step_share > kRateShare) trial.refusal = "cannot keep its rate";
    if (!felt.failure.empty()) trial.refusal = felt.failure;
    const double error = force_error_share(felt, truth.felt);
    if (felt.failure.empty() && error >= 0.0)
      trial.error_share = std::max(trial.error_share.value_or(0.0), error);
    return true;
  }
};

bool keeps_force(const RateTrial& trial) {
  return trial.error_share && *trial.error_share <= rendering::kJustNoticeable;
}

/// The lowest of the first rates in a row that keep the force, or else the most accurate.
RateTrial* best_of(std::vector<RateTrial*> usable) {
  const auto first = std::ranges::find_if(usable, [](const auto* t) { return keeps_force(*t); });
  const auto end =
      std::find_if(first, usable.end(), [](const auto* t) { return !keeps_force(*t); });
  if (first != end) return *std::prev(end);
  return *std::ranges::min_element(usable, {}, [](const RateTrial* trial) {
    return trial->error_share.value_or(std::numeric_limits<double>::infinity());
  });
}

void choose(RateChoice& choice, double share) {
  const auto pointers_to = [&](auto&& which) {
    std::vector<RateTrial*> found;
    for (RateTrial& trial : choice.trials)
      if (which(trial)) found.push_back(&trial);
    return found;
  };
  const auto could_run = [](const RateTrial& t) { return t.refusal.empty() && t.processor_share; };
  auto usable =
      pointers_to([&](const RateTrial& t) { return could_run(t) && *t.processor_share <= share; });
  choice.keeps_share = !usable.empty();
  if (usable.empty()) {  // the cheapest then
    usable = pointers_to(could_run);
    if (usable.empty()) usable = pointers_to([](const RateTrial& t) { return t.runs > 0; });
    if (usable.empty()) usable = {&choice.trials.back()};
    usable = {*std::ranges::min_element(
        usable, {}, [](const RateTrial* t) { return t->processor_share.value_or(1.0); })};
  }
  RateTrial& best = *best_of(usable);
  choice.rate_hz = best.rate_hz;
  choice.keeps_force = keeps_force(best);
  best.refusal.clear();
  for (RateTrial& trial : choice.trials) {
    if (&trial == &best || !trial.refusal.empty()) continue;
    trial.refusal = *trial.processor_share > share ? "costs more than its share"
                    : !trial.error_share           ? "nothing was touched"
                    : !keeps_force(trial)          ? "a difference is felt"
                    : trial.rate_hz > best.rate_hz ? "higher than needed"
                                                   : "a higher rate errs more";
  }
}

}  // namespace

RateChoice choose_rate(const scene::SceneDescription& scene, const bodies::World& start,
                       double budget_s, const CostClock& now_s,
                       const std::function<void(const std::string&)>& tell) {
  const HandPath hand(scene.hand->file, scene.device);
  const double began_s = now_s();
  tell("the hand, in truth");
  const Trials trials{
      .scene = scene,
      .hand = hand,
      .now_s = now_s,
      .truth = true_force(scene, start, hand, began_s + kReferenceShare * budget_s, now_s),
      .end_s = began_s + budget_s};
  RateChoice choice;
  choice.watched_s = 1e-3 * static_cast<double>(trials.truth.felt.force_N.size());
  for (const double rate_hz : kRates_hz) choice.trials.push_back({.rate_hz = rate_hz});
  const double own_hz = 1.0 / scene.period_s;
  if (!scene.choose_rate && std::ranges::none_of(kRates_hz, [&](double rate_hz) {
        return std::abs(rate_hz - own_hz) < 1e-6 * own_hz;
      }))
    choice.trials.push_back({.rate_hz = own_hz});
  std::ranges::sort(choice.trials, std::greater(), &RateTrial::rate_hz);
  for (int run = 0; run < kRuns && now_s() < trials.end_s; ++run) {
    tell("at each rate, " + std::to_string(run + 1) + " of " + std::to_string(kRuns));
    // The lowest first, which are cheap: so the most is known when time is out.
    for (auto trial = choice.trials.rbegin(); trial != choice.trials.rend(); ++trial)
      if (trial->refusal.empty() && !trials.run(*trial)) break;
  }
  for (RateTrial& trial : choice.trials)
    if (trial.runs == 0 && trial.refusal.empty()) trial.refusal = "not tried: out of time";
  choose(choice, scene.processor_share);
  return choice;
}

}  // namespace stillgrid::sim_server
