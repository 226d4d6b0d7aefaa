#include "shared/tools/scene_relay/clock_offset.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/network/relay/two_machines.hpp"

namespace stillgrid::scene_relay::clock_offset_test {
namespace {

constexpr std::uint64_t kDay_ns = 86'400'000'000'000;

/// What a millisecond's steps of the machines round off, ns.
constexpr double kRounding_ns = 10.0;

constexpr LinkSpec kLinks[] = {
    {0.02, 0.21, 0.02, 0.17, 0.0},  // one machine
    {0.4, 3.1, 0.3, 2.7, 0.011},    // a switch
    {7.3, 41.9, 6.1, 38.3, 0.053},  // another town
    {0.3, 97.1, 0.2, 5.3, 0.31},    // a way back that is another
    {0.0, 4.9, 61.7, 99.3, 0.17},
};

/// Clocks days apart, either ahead, and two drifts that differ by no more than kDrift.
TwoMachines machines(std::uint32_t seed, const LinkSpec& link) {
  std::mt19937 random(977 * seed + 13);
  const auto between = [&](double from, double to) {
    return std::uniform_real_distribution(from, to)(random);
  };
  const auto start_ns = [&] {
    return static_cast<std::uint64_t>(between(0.3, 31.7) * static_cast<double>(kDay_ns));
  };
  const double drift = between(-1e-4, 1e-4);
  const MachineClock ours(start_ns(), drift);
  const MachineClock others(start_ns(), drift + between(-0.98e-4, 0.98e-4));
  return {seed, link, ours, others};
}

/// Looks at the offset in use step by step.
class Watch {
 public:
  explicit Watch(const TwoMachines& machines) : machines_(machines) {}

  /// How far the offset is off beyond its bound; below zero, as it shall be, where it is within.
  double look() {
    const ClockOffset& offset = machines_.offset();
    if (machines_.exchanges() != exchanges_) {
      exchanges_ = machines_.exchanges();
      at_ns_ = machines_.our_ns();
    }
    const double since_ns = static_cast<double>(machines_.our_ns() - at_ns_);
    return error_ns() - static_cast<double>(offset.bound_ns()) - ClockOffset::kDrift * since_ns -
           kRounding_ns;
  }
  [[nodiscard]] double error_ns() const {
    return std::abs(
        static_cast<double>(machines_.offset().offset_ns() - machines_.true_offset_ns()));
  }

 private:
  const TwoMachines& machines_;
  std::size_t exchanges_ = 0;
  std::uint64_t at_ns_ = 0;
};

double offset_of(const Exchange& of) {
  const auto between = [](std::uint64_t from_ns, std::uint64_t to_ns) {
    return static_cast<double>(static_cast<std::int64_t>(to_ns - from_ns));
  };
  return 0.5 *
         (between(of.sent_ns, of.other_received_ns) + between(of.received_ns, of.other_sent_ns));
}

}  // namespace

TEST_CASE("The offset in use is within its bound of the truth, which is no wider than the link",
          "[clock_offset]") {
  const auto seed = GENERATE(range(1U, 6U));
  for (const LinkSpec& link : kLinks) {
    TwoMachines two = machines(seed, link);
    Watch watch(two);
    double beyond_ns = -1e18, widest_ns = 0.0;
    for (int i = 0; i < 67'000; ++i) {
      two.step();
      const double beyond = watch.look();
      if (!two.offset().is_known()) continue;
      beyond_ns = std::max(beyond_ns, beyond);
      if (i > 20'000) widest_ns = std::max(widest_ns, double(two.offset().bound_ns()));
    }
    INFO("seed " << seed << ", way there up to " << link.most_there_ms << " ms");
    REQUIRE(two.offset().is_known());
    CHECK(beyond_ns <= 0.0);
    CHECK(widest_ns < 0.5 * link.longest_trip_ns() + 1.6e6);  // 1 ms is a step of the machines
  }
}

TEST_CASE("Times that are told one after the other keep their order, and none is hurried",
          "[clock_offset]") {
  const auto seed = GENERATE(range(1U, 6U));
  for (const LinkSpec& link : kLinks) {
    TwoMachines two = machines(seed, link);
    while (!two.offset().is_known()) two.step();
    std::uint64_t last_ns = two.offset().to_ours(two.others_ns()), exchange_ns = two.our_ns();
    std::int64_t before_ns = two.offset().offset_ns();
    std::size_t exchanges = two.exchanges(), reversed = 0, hurried = 0;
    for (int i = 0; i < 53'000; ++i) {
      two.step();
      const std::uint64_t here_ns = two.offset().to_ours(two.others_ns());
      reversed += here_ns <= last_ns ? 1U : 0U;
      last_ns = here_ns;
      if (two.exchanges() == exchanges) continue;
      exchanges = two.exchanges();
      const auto passed_ns = static_cast<double>(two.our_ns() - exchange_ns);
      const auto moved_ns = std::abs(static_cast<double>(two.offset().offset_ns() - before_ns));
      hurried += moved_ns > ClockOffset::kSlew * passed_ns + 1.0 || moved_ns > 500'001.0 ? 1U : 0U;
      exchange_ns = two.our_ns();
      before_ns = two.offset().offset_ns();
    }
    INFO("seed " << seed << ", way there up to " << link.most_there_ms << " ms");
    CHECK(reversed == 0);
    CHECK(hurried == 0);
  }
}

TEST_CASE("A silence is no leap: the offset stays known and in order over it", "[clock_offset]") {
  const auto seed = GENERATE(range(1U, 8U));
  std::mt19937 random(seed);
  TwoMachines two = machines(seed, kLinks[1]);
  Watch watch(two);
  for (int i = 0; i < 9'700; ++i) two.step(), watch.look();
  std::uint64_t last_ns = 0;
  std::size_t unknown = 0, reversed = 0, beyond = 0;
  for (int silence = 0; silence < 4; ++silence) {
    two.pass(static_cast<std::uint64_t>(1e9 * std::uniform_real_distribution(3.0, 171.0)(random)));
    for (int i = 0; i < 11'300; ++i) {
      two.step();
      unknown += two.offset().is_known() ? 0U : 1U;
      beyond += watch.look() > 0.0 ? 1U : 0U;
      const std::uint64_t here_ns = two.offset().to_ours(two.others_ns());
      reversed += here_ns <= last_ns ? 1U : 0U;
      last_ns = here_ns;
    }
  }
  CHECK(unknown == 0);
  CHECK(reversed == 0);
  CHECK(beyond == 0);
}

TEST_CASE("After a machine slept the offset is known and true again within two seconds",
          "[clock_offset]") {
  const auto seed = GENERATE(range(1U, 6U));
  std::mt19937 random(31 * seed);
  for (const LinkSpec& link : kLinks) {
    TwoMachines two = machines(seed, link);
    Watch watch(two);
    for (int i = 0; i < 9'300; ++i) two.step(), watch.look();
    for (const double slept_s : {0.83, 4.7, 61.3, 3.1 * 86'400.0}) {
      const std::size_t machine = std::bernoulli_distribution(0.5)(random) ? 1U : 0U;
      two.sleep(machine, static_cast<std::uint64_t>(slept_s * 1e9));
      std::size_t unknown = 0, beyond = 0;
      for (int i = 0; i < 11'700; ++i) {
        two.step();
        const bool is_beyond = watch.look() > 0.0;
        if (i < 2'000) continue;
        unknown += two.offset().is_known() ? 0U : 1U;
        beyond += is_beyond ? 1U : 0U;
      }
      INFO("seed " << seed << ", way there up to " << link.most_there_ms << " ms, machine "
                   << machine << " slept " << slept_s << " s");
      CHECK(unknown == 0);
      CHECK(beyond == 0);
    }
  }
}

TEST_CASE("A sleep too short to tell from the link's delays is true again after 64 exchanges",
          "[clock_offset]") {
  const auto seed = GENERATE(range(1U, 8U));
  std::mt19937 random(17 * seed);
  TwoMachines two = machines(seed, kLinks[2]);
  Watch watch(two);
  for (int i = 0; i < 9'300; ++i) two.step(), watch.look();
  for (int sleep = 0; sleep < 3; ++sleep) {
    two.sleep(sleep % 2 == 0 ? 0U : 1U,
              static_cast<std::uint64_t>(1e6 * std::uniform_real_distribution(0.7, 60.0)(random)));
    const std::size_t heard = two.exchanges();
    std::size_t beyond = 0;
    for (int i = 0; i < 31'000; ++i) {
      two.step();
      const bool is_beyond = watch.look() > 0.0;
      beyond += two.exchanges() > heard + 66 && two.offset().is_known() && is_beyond ? 1U : 0U;
    }
    CHECK(beyond == 0);
  }
}

TEST_CASE("What was learnt of a link that was far worse is true again within a second",
          "[clock_offset]") {
  const auto seed = GENERATE(range(1U, 9U));
  const bool is_there = GENERATE(true, false);
  const LinkSpec bad =
      is_there ? LinkSpec{597.0, 613.0, 1.9, 2.3, 0.01} : LinkSpec{1.9, 2.3, 597.0, 613.0, 0.01};
  TwoMachines two = machines(seed, bad);
  for (int i = 0; i < 7'300; ++i) two.step();
  REQUIRE(two.offset().is_known());
  const auto off_ns = [&] {
    return std::abs(static_cast<double>(two.offset().offset_ns() - two.true_offset_ns()));
  };
  CHECK(off_ns() > 2e8);  // half of what the ways differ: nobody could know better
  two.change({1.9, 2.3, 1.9, 2.3, 0.01});
  for (int i = 0; i < 1'900; ++i) two.step();
  CHECK(off_ns() < 2e6);
  CHECK(off_ns() <= static_cast<double>(two.offset().bound_ns()));
}

TEST_CASE("Stamps that no exchange can have change nothing", "[clock_offset]") {
  const auto seed = GENERATE(range(1U, 4U));
  TwoMachines two = machines(seed, kLinks[1]);
  for (int i = 0; i < 5'700; ++i) two.step();
  ClockOffset offset = two.offset();
  const std::int64_t offset_ns = offset.offset_ns();
  const std::uint64_t bound_ns = offset.bound_ns(), trip_ns = offset.round_trip_ns();
  const Exchange good = two.last_exchange();
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  std::size_t taken = 0, changed = 0, tried = 0;
  const auto try_one = [&](Exchange exchange) {
    ++tried;
    taken += offset.add(exchange) ? 1U : 0U;
    changed += offset.offset_ns() != offset_ns || offset.bound_ns() != bound_ns ||
                       offset.round_trip_ns() != trip_ns || !offset.is_known()
                   ? 1U
                   : 0U;
  };
  for (const std::uint64_t odd :
       {std::uint64_t{0}, std::uint64_t{1}, kLargest, kLargest / 2, kLargest / 4})
    for (int which = 0; which < 4; ++which) {
      Exchange exchange = good;
      (which == 0   ? exchange.sent_ns
       : which == 1 ? exchange.other_received_ns
       : which == 2 ? exchange.other_sent_ns
                    : exchange.received_ns) = odd;
      try_one(exchange);
    }
  try_one({good.received_ns + 1, good.other_received_ns, good.other_sent_ns, good.received_ns});
  try_one({good.sent_ns, good.other_sent_ns + 1, good.other_sent_ns, good.received_ns});
  try_one({good.sent_ns, good.other_received_ns, good.other_sent_ns, good.received_ns - 1});
  try_one({good.sent_ns, good.other_received_ns,  // held longer than the whole took
           good.other_received_ns + (good.received_ns - good.sent_ns) + 1, good.received_ns});
  try_one({good.sent_ns, good.other_received_ns, good.other_sent_ns,
           good.received_ns + 10'000'000'001});
  for (const std::uint64_t later_ns : {kLargest / 4, kLargest / 2})  // no clock runs for that long
    try_one({good.sent_ns + later_ns, good.other_received_ns + later_ns,
             good.other_sent_ns + later_ns, good.received_ns + later_ns});
  CHECK(tried == 27);
  CHECK(taken == 0);
  CHECK(changed == 0);
}

TEST_CASE("A time that is none on the other clock is its first or its last", "[clock_offset]") {
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  constexpr std::uint64_t kLate_ns = std::uint64_t{1} << 61U;
  ClockOffset ahead, behind;
  for (std::uint64_t i = 0; i < 5; ++i) {
    const std::uint64_t now_ns = 7'000 + 1'000'003 * i, there_ns = kLate_ns - 90'000'000 + now_ns;
    REQUIRE(ahead.add({now_ns, there_ns + 400, there_ns + 500, now_ns + 900}));
    REQUIRE(behind.add({there_ns, now_ns + 400, now_ns + 500, there_ns + 900}));
  }
  CHECK(ahead.to_ours(41) == 0);
  CHECK(behind.to_others(41) == 0);
  CHECK(ahead.to_ours(kLargest) == kLargest);
  CHECK(behind.to_others(kLargest - 3) == kLargest - 3);
  CHECK(ahead.to_others(kLate_ns) > kLate_ns);
  CHECK(behind.to_ours(kLate_ns) > kLate_ns);
  CHECK(ahead.to_ours(ahead.to_others(23'456'789)) == 23'456'789);
}

TEST_CASE("Simpler ways to tell the time fail as predicted", "[clock_offset]") {
  const auto seed = GENERATE(range(1U, 6U));
  const LinkSpec& link = kLinks[3];
  TwoMachines two = machines(seed, link);
  for (int i = 0; i < 9'100; ++i) two.step();
  double copied_ns = 0.0, newest_ns = 0.0, ours_ns = 0.0, last_ns = 0.0;
  std::size_t looks = 0, reversed = 0, heard = 0;
  const Watch watch(two);
  for (int i = 0; i < 180'000; ++i) {
    two.step();
    const auto truth_ns = static_cast<double>(two.true_offset_ns());
    const double by_newest_ns = offset_of(two.last_exchange());
    const double here_ns = static_cast<double>(two.our_ns()) - (by_newest_ns - truth_ns);
    reversed += here_ns <= last_ns ? 1U : 0U;
    last_ns = here_ns;
    if (two.exchanges() == heard) continue;
    heard = two.exchanges();
    ++looks;
    copied_ns += std::abs(truth_ns);
    newest_ns += std::abs(by_newest_ns - truth_ns);
    ours_ns += watch.error_ns();
  }
  REQUIRE(looks > 400);
  const auto n = static_cast<double>(looks);
  // A time that is copied is off by all that the clocks are apart. By the last exchange it is off
  // by half of what its ways differ, a little less as what came sooner is longer the last, and it
  // steps back where that grows.
  const double predicted_ns =
      0.25e6 * (link.most_there_ms + link.least_there_ms - link.most_back_ms - link.least_back_ms);
  CHECK(copied_ns / n > 0.01 * static_cast<double>(kDay_ns));
  CHECK(newest_ns / n > 0.6 * predicted_ns);
  CHECK(newest_ns / n < 1.1 * predicted_ns);
  CHECK(reversed > looks / 5);
  CHECK(ours_ns / n < 0.2 * predicted_ns);
}

}  // namespace stillgrid::scene_relay::clock_offset_test
