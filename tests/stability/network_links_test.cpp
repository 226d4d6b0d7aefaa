// Packets of the laboratory's network: what is lost, when the rest comes.

#include "tests/laboratory/network_links.hpp"

#include <catch2/catch.hpp>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

namespace stillgrid::laboratory::network_links_test {
namespace {

constexpr std::uint64_t kMs_ns = 1'000'000;

proto::ToolState tool_at(std::uint64_t time_ns) {
  proto::ToolState state{};
  state.time_ns = time_ns;
  return state;
}

SentSnapshot snapshot_at(std::uint64_t publish_ns) {
  SentSnapshot snapshot;
  snapshot.times.publish_ns = publish_ns;
  return snapshot;
}

/// All that come of `count` snapshots, one every period, the link being asked every millisecond.
std::vector<ArrivedSnapshot> arrivals(SnapshotLink& link, std::uint64_t count,
                                      std::uint64_t period_ns) {
  std::vector<ArrivedSnapshot> all;
  const std::uint64_t end_ns = count * period_ns;
  for (std::uint64_t now_ns = 0; now_ns < end_ns + 2'000 * kMs_ns; now_ns += kMs_ns) {
    if (now_ns % period_ns == 0 && now_ns < end_ns) link.send(snapshot_at(now_ns));
    for (ArrivedSnapshot& arrived : link.take(now_ns)) all.push_back(std::move(arrived));
  }
  return all;
}

}  // namespace

TEST_CASE("Whatever its packets meet, the tool never goes back in time", "[network]") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    ToolLink link({.delay_s = 0.0173, .delay_jitter = 0.8, .loss = 0.23}, seed);
    std::uint64_t before_ns = 0, came = 0;
    for (std::uint64_t now_ns = kMs_ns; now_ns < 3'000 * kMs_ns; now_ns += kMs_ns) {
      link.send(tool_at(now_ns));
      const auto& newest = link.newest(now_ns);
      if (!newest) continue;
      CAPTURE(seed, now_ns);
      REQUIRE(newest->sample.time_ns >= before_ns);
      REQUIRE(newest->arrival_ns <= now_ns);
      REQUIRE(newest->arrival_ns - newest->sample.time_ns >= 3 * kMs_ns);
      if (newest->sample.time_ns > before_ns) ++came;
      before_ns = newest->sample.time_ns;
    }
    CHECK(came > 300);
    CHECK(came < 2'400);  // some were lost, some overtaken
  }
}

TEST_CASE("Without loss a snapshot comes its delay later, of whatever size", "[network]") {
  SnapshotLink link({.delay_s = 0.0421}, 123'456, 1);
  const auto all = arrivals(link, 50, 33 * kMs_ns);
  REQUIRE(all.size() == 50);
  for (const ArrivedSnapshot& arrived : all)
    CHECK(arrived.arrival_ns - arrived.snapshot.times.publish_ns == 42'100'000);
}

TEST_CASE("A lost fragment costs round trips, or the snapshot where the next is sent before",
          "[network]") {
  const std::uint64_t delay_ms = GENERATE(as<std::uint64_t>{}, 3, 11, 41);
  constexpr std::uint64_t kPeriod_ms = 33;
  constexpr std::uint64_t kCount = 3'000;
  SnapshotLink link({.delay_s = 1e-3 * static_cast<double>(delay_ms), .loss = 0.04}, 9'000, 5);
  const auto all = arrivals(link, kCount, kPeriod_ms * kMs_ns);
  CHECK(all.size() + link.replaced() == kCount);
  CHECK(link.late() == 0);
  std::set<std::uint64_t> rounds;
  for (const ArrivedSnapshot& arrived : all) {
    const std::uint64_t sent_ns = arrived.snapshot.times.publish_ns;
    if (sent_ns == (kCount - 1) * kPeriod_ms * kMs_ns) continue;  // no next one replaces it
    const std::uint64_t took_ns = arrived.arrival_ns - sent_ns;
    REQUIRE((took_ns - delay_ms * kMs_ns) % (2 * delay_ms * kMs_ns) == 0);
    rounds.insert((took_ns - delay_ms * kMs_ns) / (2 * delay_ms * kMs_ns));
  }
  CAPTURE(delay_ms);
  // A request that reaches the sender before the next snapshot is heard.
  CHECK(*rounds.rbegin() <= kPeriod_ms / (2 * delay_ms));
  // Seven fragments come at once by 0.96^7.
  const auto at_once = static_cast<double>(all.size()) / kCount;
  if (2 * delay_ms > kPeriod_ms) CHECK(at_once == Approx(0.751).margin(0.03));
  if (2 * delay_ms < kPeriod_ms) CHECK(rounds.contains(1));
}

TEST_CASE("The more snapshots the sender keeps, the fewer are replaced before they came",
          "[network]") {
  std::uint64_t before = 3'000;
  for (const std::size_t kept : {1U, 2U, 3U}) {
    SnapshotLink link({.delay_s = 0.021, .loss = 0.04}, 9'000, 5, kept);
    const auto all = arrivals(link, 3'000, 33 * kMs_ns);
    CAPTURE(kept, link.replaced());
    CHECK(link.replaced() < before);
    before = link.replaced();
  }
  CHECK(before < 100);
}

TEST_CASE("Snapshots are shown in order, each once, none that was too long on its way",
          "[network]") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SnapshotLink link({.delay_s = 0.06, .delay_jitter = 0.9, .loss = 0.2}, 4'000, seed);
    const auto all = arrivals(link, 400, 471 * kMs_ns);
    std::uint64_t before_ns = 0;
    for (const ArrivedSnapshot& arrived : all) {
      const std::uint64_t sent_ns = arrived.snapshot.times.publish_ns;
      CAPTURE(seed, sent_ns);
      REQUIRE((sent_ns > before_ns || &arrived == &all.front()));
      REQUIRE(arrived.arrival_ns - sent_ns <= kOldestSnapshot_ns);
      before_ns = sent_ns;
    }
    CHECK(link.late() > 0);
    CHECK(all.size() + link.late() + link.replaced() == 400);
  }
}

}  // namespace stillgrid::laboratory::network_links_test
