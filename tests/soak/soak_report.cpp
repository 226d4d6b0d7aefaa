#include "tests/soak/soak_report.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace stillgrid::soak {
namespace {

nlohmann::ordered_json percentiles(const realtime::Histogram& histogram) {
  return {{"p50", histogram.percentile(0.5)},
          {"p99", histogram.percentile(0.99)},
          {"p999", histogram.percentile(0.999)},
          {"max", histogram.max()}};
}

double share(std::uint64_t part, std::uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole > 0 ? whole : 1);
}

/// A law, and whether it was kept.
struct Law {
  bool is_kept;
  std::string name;
};

std::vector<Law> laws_of(const SoakPlan& plan, const ReaderTally& reader, bool is_complete) {
  if (plan.skips_last_check)
    return {{is_complete, "complete"}, {reader.torn > 0, "torn > 0 without the last check"}};
  std::vector<Law> laws{{is_complete, "complete"},
                        {reader.ticks > 0, "ticks > 0"},
                        {reader.torn == 0, "torn = 0"},
                        {reader.mixed == 0, "mixed = 0"},
                        {reader.backwards == 0, "backwards = 0"},
                        {reader.refusals == 0, "refusals = 0"}};
  if (plan.spacing_ns > 0 || plan.kills > 0)
    laws.push_back({reader.nothing_shown == 0, "nothing shown = 0"});
  if (plan.spacing_ns > 0)
    laws.push_back({share(reader.accepted, reader.ticks) >= 0.99, "accepted >= 99 %"});
  return laws;
}

std::vector<Law> laws_of(const SoakPlan& plan, const ReaderTally& reader, const KillTally& kills) {
  const auto in_mid_write = kills.deaths[static_cast<std::size_t>(Death::kInMidWrite)];
  return {{in_mid_write * 10 >= plan.kills, "a tenth killed in mid-write"},
          {reader.segments * 2 >= plan.kills, "half of the writers are read"},
          {kills.read_ns.count() + 1 == plan.kills, "every kill but the last is measured"},
          {reader.inspected > 0, "inspected > 0"},
          {kills.locks_left == 0, "locks left = 0"},
          {kills.snapshots_lost == 0, "snapshots lost = 0"},
          {kills.leftovers == 0, "leftovers = 0"},
          {kills.last_death_seen, "the last death is seen"},
          {kills.last_writer_read, "the last writer is read"}};
}

nlohmann::ordered_json of_kills(const KillTally& kills) {
  nlohmann::ordered_json deaths;
  for (std::size_t i = 0; i < kDeathNames.size(); ++i) deaths[kDeathNames[i]] = kills.deaths[i];
  nlohmann::ordered_json later = percentiles(kills.read_ns);
  later["mean"] = share(kills.read_sum_ns, kills.read_ns.count());
  later["count"] = kills.read_ns.count();
  return {{"killed", deaths},
          {"locks_left", kills.locks_left},
          {"snapshots_lost", kills.snapshots_lost},
          {"leftovers", kills.leftovers},
          {"later_writer_read_ns", later}};
}

}  // namespace

nlohmann::ordered_json soak_report(const SoakPlan& plan, const SoakState& state,
                                   const std::optional<KillTally>& kills, bool is_complete,
                                   double seconds) {
  const ReaderTally& reader = state.reader;
  nlohmann::ordered_json report = {
      {"mode", kills ? "kills" : "publications"},
      {"bytes", plan.bytes},
      {"words_a_tick", plan.words_a_tick > 0 ? plan.words_a_tick : plan.words()},
      {"spacing_us", plan.spacing_ns / 1000},
      {"seconds", seconds},
      {"publications", state.publish_ns.count()},
      {"snapshots_read", reader.snapshots},
      {"ticks", reader.ticks},
      {"missed_ticks", reader.missed_ticks},
      {"ticks_before_a_snapshot", reader.ticks_before_a_snapshot},
      {"accepted", reader.accepted},
      {"accepted_share", share(reader.accepted, reader.ticks)},
      {"torn", reader.torn},
      {"mixed", reader.mixed},
      {"backwards", reader.backwards},
      {"rejected_attempts", reader.failed_attempts[1] + 2 * reader.failed_attempts[2]},
      {"ticks_by_failed_attempts", reader.failed_attempts},
      {"nothing_shown", reader.nothing_shown},
      {"refusals", reader.refusals},
      {"realtime_rights_missing", reader.realtime_missing},
      {"read_ns", percentiles(reader.read_ns)},
      {"publish_ns", percentiles(state.publish_ns)}};
  if (reader.wake_ns.count() > 0) report["wake_ns"] = percentiles(reader.wake_ns);

  std::vector<Law> laws = laws_of(plan, reader, is_complete);
  if (kills) {
    report.update(of_kills(*kills));
    report["kills"] = plan.kills;
    report["segments_read"] = reader.segments;
    report["deaths_seen"] = reader.deaths_seen;
    report["inspected"] = reader.inspected;
    report["inspections_rejected"] = reader.inspections_rejected;
    const std::vector<Law> more = laws_of(plan, reader, *kills);
    laws.insert(laws.end(), more.begin(), more.end());
  }
  report["broken_laws"] = nlohmann::ordered_json::array();
  for (const Law& law : laws)
    if (!law.is_kept) report["broken_laws"].push_back(law.name);
  return report;
}

void print(const nlohmann::ordered_json& report) {
  for (const auto& [name, value] : report.items()) {
    std::string text = name;
    std::replace(text.begin(), text.end(), '_', ' ');
    std::printf("  %-26s%s\n", text.c_str(), value.dump().c_str());
  }
}

}  // namespace stillgrid::soak
