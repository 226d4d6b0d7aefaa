#include "tests/network/link_direction.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "tests/network/link_settings.hpp"

namespace stillgrid::network::link_direction_test {
namespace {

constexpr std::uint64_t kBegin_ns = 7'654'321'987;
constexpr std::uint32_t kPackets = 6'000;

struct Arrival {
  std::uint32_t number;
  std::uint64_t sent_ns, at_ns;
};

/// A link in virtual time, whose packets hold their number and when they were sent.
struct Run {
  LinkDirection link;
  std::vector<Arrival> arrivals;
  std::uint64_t now_ns = kBegin_ns;

  Run(std::uint64_t seed, const LinkSettings& settings) : link(seed) { link.settings = settings; }

  void deliver() {
    link.deliver_due(now_ns, [this](std::span<const std::uint8_t> packet) {
      Arrival arrival{0, 0, now_ns};
      std::memcpy(&arrival.number, packet.data(), sizeof arrival.number);
      std::memcpy(&arrival.sent_ns, packet.data() + 8, sizeof arrival.sent_ns);
      arrivals.push_back(arrival);
      return true;
    });
  }
  void go_on_until(std::uint64_t end_ns) {
    while (link.next_due_ns().value_or(end_ns) < end_ns) {
      now_ns = std::max(now_ns, *link.next_due_ns());
      deliver();
    }
    now_ns = end_ns;
  }
  void send(std::uint32_t number, std::size_t size = 100) {
    std::vector<std::uint8_t> packet(size);
    std::memcpy(packet.data(), &number, sizeof number);
    std::memcpy(packet.data() + 8, &now_ns, sizeof now_ns);
    link.send(packet, now_ns);
  }
  /// At odd distances of about 0.3 ms, and until all have arrived.
  void send_all(std::uint64_t seed, std::uint32_t count = kPackets) {
    std::mt19937_64 random(seed);
    for (std::uint32_t i = 0; i < count; ++i) {
      go_on_until(now_ns + 100'003 + random() % 400'000);
      send(i);
    }
    go_on_until(now_ns + 20'000'000'000);
  }
};

bool is_near_share(std::uint64_t count, double share, double of) {
  return std::abs(static_cast<double>(count) - share * of) <=
         5.0 * std::sqrt(share * (1.0 - share) * of);
}

/// Of each arrival, how far beyond `delay_ms` it took.
std::vector<double> beyond_ms(const std::vector<Arrival>& arrivals, double delay_ms) {
  std::vector<double> beyond;
  beyond.reserve(arrivals.size());
  for (const Arrival& arrival : arrivals)
    beyond.push_back(static_cast<double>(arrival.at_ns - arrival.sent_ns) * 1e-6 - delay_ms);
  return beyond;
}

bool is_in_order(const std::vector<Arrival>& arrivals) {
  return std::is_sorted(arrivals.begin(), arrivals.end(),
                        [](const Arrival& a, const Arrival& b) { return a.number < b.number; });
}

}  // namespace

TEST_CASE("Over a link that only delays, each packet arrives once, in order, after that delay") {
  const auto seed = GENERATE(1U, 23U, 456U);
  const double delay_ms = GENERATE(0.0, 0.37, 10.3);
  LinkSettings settings;
  settings.delay_ms = delay_ms;
  Run run(seed, settings);
  run.send_all(seed);
  REQUIRE(run.arrivals.size() == kPackets);
  CHECK(is_in_order(run.arrivals));
  for (const double beyond : beyond_ms(run.arrivals, delay_ms)) REQUIRE(std::abs(beyond) < 2e-6);
}

TEST_CASE("As many packets as asked are lost, doubled and held back, and none is unaccounted for") {
  const auto seed = GENERATE(1U, 23U, 456U);
  LinkSettings settings;
  settings.delay_ms = 3.3;
  settings.loss = 0.043;
  settings.duplicate = 0.029;
  settings.reorder = 0.071;
  Run run(seed, settings);
  run.send_all(seed);
  const LinkCounters& counters = run.link.counters();
  CHECK(counters.sent == kPackets);
  CHECK(is_near_share(counters.lost, settings.loss, kPackets));
  const auto kept = static_cast<double>(counters.sent - counters.lost);
  CHECK(is_near_share(counters.duplicated, settings.duplicate, kept));
  CHECK(is_near_share(counters.reordered, settings.reorder, kept * (1.0 + settings.duplicate)));
  CHECK(counters.delivered == counters.sent + counters.duplicated - counters.lost);
  CHECK(run.arrivals.size() == counters.delivered);
}

TEST_CASE("A packet that is held back is late by what was asked, and the others keep their order") {
  const auto seed = GENERATE(1U, 23U, 456U);
  LinkSettings settings;
  settings.delay_ms = 1.3;
  settings.reorder = 0.1;
  settings.reorder_ms = 4.7;
  Run run(seed, settings);
  run.send_all(seed);
  const std::vector<double> beyond = beyond_ms(run.arrivals, settings.delay_ms);
  std::vector<Arrival> punctual;
  for (std::size_t i = 0; i < beyond.size(); ++i) {
    if (beyond[i] < 1e-3)
      punctual.push_back(run.arrivals[i]);
    else
      REQUIRE(beyond[i] == Approx(settings.reorder_ms).margin(2e-6));
  }
  CHECK(run.arrivals.size() - punctual.size() == run.link.counters().reordered);
  CHECK(is_in_order(punctual));
  CHECK_FALSE(is_in_order(run.arrivals));
}

TEST_CASE("Jitter wanders between nothing and itself, over all of that, and keeps the order") {
  const auto seed = GENERATE(1U, 23U, 456U);
  const double jitter_ms = GENERATE(2.9, 31.0);
  LinkSettings settings;
  settings.delay_ms = 5.1;
  settings.jitter_ms = jitter_ms;
  Run run(seed, settings);
  run.send_all(seed);
  CHECK(is_in_order(run.arrivals));
  std::vector<double> beyond = beyond_ms(run.arrivals, settings.delay_ms);
  for (std::size_t i = 1; i < beyond.size(); ++i) {
    const std::uint64_t gap_ns = run.arrivals[i].sent_ns - run.arrivals[i - 1].sent_ns;
    REQUIRE(std::abs(beyond[i] - beyond[i - 1]) < static_cast<double>(gap_ns) * 1e-6 + 2e-6);
  }
  std::sort(beyond.begin(), beyond.end());
  CHECK(beyond.front() > -2e-6);
  CHECK(beyond.back() < jitter_ms + 2e-6);
  CHECK(beyond[kPackets / 10] < 0.35 * jitter_ms);
  CHECK(beyond[kPackets - kPackets / 10] > 0.65 * jitter_ms);
}

TEST_CASE("A rate lets no more bits through, and drops what would wait longer than 100 ms") {
  const auto seed = GENERATE(1U, 23U);
  LinkSettings settings;
  settings.rate_Mbit_per_s = 7.3;
  Run run(seed, settings);
  constexpr std::size_t kSize = 1'400;
  for (std::uint32_t i = 0; i < 2'000; ++i) run.send(i, kSize);  // at once
  run.go_on_until(run.now_ns + 1'000'000'000);
  const LinkCounters& counters = run.link.counters();
  const double packets_per_s = settings.rate_Mbit_per_s * 1e6 / (8.0 * kSize);
  CHECK(counters.delivered + counters.overflowed == counters.sent);
  CHECK(static_cast<double>(counters.delivered) == Approx(0.1 * packets_per_s).margin(2.0));
  for (std::size_t i = 0; i < run.arrivals.size(); ++i)
    REQUIRE(static_cast<double>(run.arrivals[i].at_ns - kBegin_ns) * 1e-9 ==
            Approx(static_cast<double>(i + 1) / packets_per_s).margin(1e-6));
}

TEST_CASE("A partition lets nothing in, and what was on its way arrives") {
  LinkSettings settings;
  settings.delay_ms = 20.9;
  Run run(1, settings);
  run.send(0);
  run.link.settings.is_partitioned = true;
  for (std::uint32_t i = 1; i <= 30; ++i) run.send(i);
  run.go_on_until(run.now_ns + 1'000'000'000);
  run.link.settings.is_partitioned = false;
  run.send(31);
  run.go_on_until(run.now_ns + 1'000'000'000);
  REQUIRE(run.arrivals.size() == 2);
  CHECK(run.arrivals[0].number == 0);
  CHECK(run.arrivals[1].number == 31);
  CHECK(run.link.counters().partitioned == 30);
}

TEST_CASE("The same seed has the same fate, and another seed another") {
  LinkSettings settings;
  settings.delay_ms = 2.2;
  settings.jitter_ms = 1.7;
  settings.loss = settings.duplicate = settings.reorder = 0.1;
  const auto times = [&](std::uint64_t seed) {
    Run run(seed, settings);
    run.send_all(99, 500);
    std::vector<std::uint64_t> all;
    for (const Arrival& arrival : run.arrivals) all.push_back(arrival.at_ns);
    return all;
  };
  CHECK(times(5) == times(5));
  CHECK(times(5) != times(6));
}

TEST_CASE("A setting that is none is refused by key and value") {
  LinkSettings settings;
  for (const auto& [key, value] :
       {std::pair("loss", "1.01"), std::pair("loss", "nan"), std::pair("loss", "-0.1"),
        std::pair("delay_ms", "10ms"), std::pair("partition", "yes"), std::pair("los", "0.1")}) {
    try {
      apply_setting(settings, key, value);
      FAIL(key << " " << value);
    } catch (const std::runtime_error& error) {
      CHECK_THAT(error.what(), Catch::Contains(key) && Catch::Contains("expected"));
    }
  }
  apply_setting(settings, "loss", "0.25");
  CHECK(settings.loss == 0.25);
}

}  // namespace stillgrid::network::link_direction_test
