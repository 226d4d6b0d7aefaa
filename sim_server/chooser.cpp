#include "sim_server/chooser.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <stdexcept>

#include "sim_server/scene/build_world.hpp"

namespace stillgrid::sim_server {
namespace {

constexpr std::array kPeriods_ms = {1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 30.0, 50.0, 70.0, 100.0};
constexpr double kEnoughError = 2.0 * rendering::kJustNoticeable;

template <class... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 300> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

Candidate candidate_of(const scene::SceneDescription& scene, double rate_hz,
                       const scene::Method& method) {
  Candidate candidate;
  candidate.scene = scene;
  candidate.scene.period_s = 1.0 / rate_hz;
  candidate.scene.method = method;
  candidate.record.name = print("%.4g Hz, ", rate_hz) + scene::describe(method);
  candidate.record.settings = {
      print("simulation.rate_hz=%.9g", rate_hz),
      print("simulation.integrator=\"%s\"", name_of(method.integrator).data())};
  if (method.substeps > 0)
    candidate.record.settings.push_back(print("simulation.substeps=%d", method.substeps));
  return candidate;
}

/// Judges candidates of one scene, which share their starts where they come to rest alike.
class SharedStarts {
 public:
  explicit SharedStarts(const Judge& judge) : judge_(judge) {}

  Judgement judge(const Candidate& candidate, const Enough& enough) {
    const scene::SceneDescription& scene = candidate.scene;
    const std::string key = scene::describe(scene.method) + print(" %.9g", rest_step_s(scene));
    Judgement judgement{candidate.record, 0.0};
    try {
      const auto [found, is_new] = starts_.try_emplace(key);
      if (is_new) found->second = judge_.rest_of(scene);
      judgement = judge_.judge(candidate, found->second, enough);
      found->second.work = 0.0;  // counts once
    } catch (const std::domain_error&) {
      starts_.erase(key);
      judgement.record.refusal = "unstable";
    }
    return judgement;
  }

 private:
  const Judge& judge_;
  std::map<std::string, StartState> starts_;
};

}  // namespace

std::vector<Candidate> candidates_of(const scene::SceneDescription& scene, bool all) {
  const dynamics::SceneLoad load = dynamics::load_of(scene::build_world(scene));
  std::vector<Candidate> candidates;
  const auto add = [&](double rate_hz, const scene::Method& method) {
    Candidate candidate = candidate_of(scene, rate_hz, method);
    if (std::ranges::none_of(candidates, [&](const Candidate& other) {
          return other.record.name == candidate.record.name;
        }))
      candidates.push_back(std::move(candidate));
  };
  const auto method_at = [&](double rate_hz) {
    return scene.choose_method ? dynamics::choose_method(load, 1.0 / rate_hz).method : scene.method;
  };
  const double own_hz = 1.0 / scene.period_s;
  if (!scene.choose_rate) add(own_hz, method_at(own_hz));
  if (all)
    for (const scene::Method& method :
         {scene::Method{.integrator = scene::IntegratorKind::kVelocityVerlet}, scene::Method{}})
      add(own_hz, method);
  if (scene.choose_rate || all)
    for (const double period_ms : kPeriods_ms) add(1e3 / period_ms, method_at(1e3 / period_ms));
  return candidates;
}

Choice choose(const scene::SceneDescription& scene, std::vector<Candidate> candidates,
              double most_work, const std::function<void(const std::string&)>& report) {
  report(print("the hand, in truth: velocity_verlet at %g Hz", kTruth_hz));
  const Judge judge(scene, most_work);
  SharedStarts starts(judge);
  Choice choice;
  choice.truth_error_share = judge.truth().error_share;
  choice.watched_s = judge.watched_s();
  choice.limits.work_per_ms = scene.processor_share * dynamics::kWorkPerProcessor_ms;
  choice.records.resize(candidates.size());
  Enough enough{kEnoughError, choice.limits.work_per_ms, choice.limits.work_per_ms};
  double work = 0.0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    choice.records[i] = candidates[i].record;
    if (work > most_work) {
      choice.records[i].refusal = "not tried: out of budget";
      continue;
    }
    report(candidates[i].record.name);
    const Judgement judgement = starts.judge(candidates[i], enough);
    const choice::Record& record = choice.records[i] = judgement.record;
    if (record.refusal.empty() && choice::keeps_error(record, choice.limits))
      enough.work_per_ms = std::min(enough.work_per_ms, choice::kEqualWork * record.work_per_ms);
    work += judgement.work;
  }
  choice.chosen = std::move(candidates[choice::choose_record(choice.records, choice.limits)]);
  return choice;
}

std::string complaint_of(const Choice& choice) {
  const auto chosen =
      std::ranges::find_if(choice.records, &std::string::empty, &choice::Record::refusal);
  if (chosen->work_per_ms > choice.limits.work_per_ms)
    return "no candidate costs less than its share of a processor: this is the cheapest";
  if (!chosen->error_share)
    return print("the force's error is unknown: the hand had no contact in %.3g s",
                 choice.watched_s);
  if (choice.truth_error_share > 0.5 * choice.limits.error_share)
    return print(
        "the truth itself differs by %.3g %% from one of half its rate a micrometre beside: errors "
        "are known to within that",
        100.0 * choice.truth_error_share);
  if (!choice::keeps_error(*chosen, choice.limits))
    return "no candidate within its share of a processor keeps the force within a just noticeable "
           "difference: this is the most accurate";
  return "";
}

}  // namespace stillgrid::sim_server
