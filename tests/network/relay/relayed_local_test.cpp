// The local copy over a relay, in virtual time: it renders what it renders beside the simulation.
#include <catch2/catch.hpp>
#include <functional>

#include "tests/network/relay/relayed_session.hpp"

namespace stillgrid::scene_relay::relayed_local_test {
namespace {

constexpr std::uint64_t kBegin = 50'000;  // ticks

/// What the hand felt, by tick.
using Felt = std::map<std::uint64_t, FeltTick>;

/// Simulation and hand on one machine, at 1 kHz each: the simulation's own force in each tick.
Felt beside(std::uint64_t ticks) {
  const publication::TestSession session;
  PathSimulation simulation(session.name(), 1);
  PathHand hand(session.name());
  Felt felt;
  for (std::uint64_t n = kBegin; n < kBegin + ticks; ++n) {
    hand.move_to(n);
    simulation.step(n);
    felt[n] = hand.render(n);
  }
  for (const auto& [n, state] : simulation.states())
    if (felt.contains(n) && felt[n].tick.is_local && felt[n].state != state) FAIL_CHECK(n);
  return felt;
}

struct Relayed {
  RelayedLink link;
  std::int64_t offset_ns = 0;
  double drift = 0.0;
  std::uint64_t period = 10;  // of the simulation, ticks
  std::uint32_t seed = 1;
};

/// The same over a relay.
class RelayedRun {
 public:
  explicit RelayedRun(const Relayed& spec)
      : spec_(spec),
        simulation_(there_.name(), spec.period),
        hand_(here_.name()),
        relay_(there_.name(), here_.name(), spec.link, spec.offset_ns, spec.drift, spec.seed) {}

  [[nodiscard]] RelayParts& relay() noexcept { return relay_; }
  [[nodiscard]] const Felt& felt() const noexcept { return felt_; }

  void go_on(std::uint64_t ticks) {
    for (const std::uint64_t end = now_ + ticks; now_ < end; ++now_) {
      hand_.move_to(now_);
      relay_.carry_tool(now_);
      if (now_ % spec_.period == 0) simulation_.step(relay_.simulation_ns(now_) / kMs_ns);
      relay_.carry_snapshots(now_);
      felt_[now_] = hand_.render(now_);
    }
  }

  /// Ticks that were local, and whose copy was not the simulation's state in that tick. Those that
  /// the simulation has not come to yet do not count.
  struct Local {
    std::size_t ticks = 0, wrong = 0, swaps = 0;
  };
  [[nodiscard]] Local local(std::uint64_t from) const {
    Local local;
    for (const auto& [number, state] : simulation_.states()) {
      const auto felt = felt_.find(relay_.tool().hands_number(number).value());
      if (felt == felt_.end() || felt->first < from || !felt->second.tick.is_local) continue;
      ++local.ticks;
      local.wrong += felt->second.state != state ? 1U : 0U;
      local.swaps += felt->second.tick.is_swap ? 1U : 0U;
    }
    return local;
  }

 private:
  Relayed spec_;
  publication::TestSession there_, here_;
  PathSimulation simulation_;
  PathHand hand_;
  RelayParts relay_;
  Felt felt_;
  std::uint64_t now_ = kBegin;
};

/// The first tick from which all are local.
std::uint64_t first_local(const Felt& felt) {
  std::uint64_t first = kBegin;
  for (const auto& [tick, of_tick] : felt)
    if (!of_tick.tick.is_local) first = tick + 1;
  return first;
}

}  // namespace

TEST_CASE("Over a relay the force is the simulation's to the bit, whatever the delay and the loss",
          "[relayed_local]") {
  const std::uint64_t delay = GENERATE(0U, 20U, 100U);
  const double loss = GENERATE(0.0, 0.2);
  const std::uint64_t period = GENERATE(10U, 33U);
  constexpr std::uint64_t kTicks = 2000;
  const Felt without = beside(kTicks);
  RelayedRun run({.link = {.delay = delay, .jitter = delay / 12, .loss = loss}, .period = period});
  run.go_on(kTicks);
  INFO("delay " << delay << " ms, loss " << loss << ", period " << period);
  std::uint64_t begin = std::max(first_local(run.felt()), first_local(without));
  CHECK(begin < kBegin + 200 + 5 * delay + 5 * period);
  // A hand's proxy remembers what it touched before the copy was there, until it lets go. What the
  // switch to the copy changed is eased out.
  while (!run.felt().at(begin).tick.force.force_N.isZero(0.0) ||
         !without.at(begin).tick.force.force_N.isZero(0.0))
    ++begin;
  std::size_t other = 0, pressed = 0, swaps = 0;
  for (std::uint64_t n = begin; n < kBegin + kTicks; ++n) {
    const FeltTick& felt = run.felt().at(n);
    other += felt.is_same_force(without.at(n)) && felt.state == without.at(n).state ? 0U : 1U;
    pressed += felt.tick.force.contacts > 0 ? 1U : 0U;
    swaps += n > begin && felt.tick.is_swap ? 1U : 0U;
  }
  CHECK(other == 0);
  CHECK(pressed > 400);
  CHECK(swaps == 0);
  CHECK(run.relay().refused == 0);
  CHECK(run.local(begin).wrong == 0);
  // The account of energy joins the two sides in a tick of the hand.
  for (const std::uint64_t time_ns : run.relay().tool_times)
    CHECK((time_ns % kMs_ns == 0 && run.felt().contains(time_ns / kMs_ns)));
}

TEST_CASE("Clocks that are apart by no whole number of ticks, and drift, change no number",
          "[relayed_local]") {
  const std::int64_t offset_ns = GENERATE(987'654'321'987, -31'234'567'891, 499'999);
  const double drift = GENERATE(1e-4, -1e-4);
  RelayedRun run(
      {.link = {.delay = 20, .jitter = 3, .loss = 0.1}, .offset_ns = offset_ns, .drift = drift});
  run.go_on(12'000);  // the clocks drift by more than a tick
  const std::uint64_t begin = first_local(run.felt());
  CHECK(begin < kBegin + 400);
  const RelayedRun::Local local = run.local(begin + 1);
  CHECK(local.ticks > 11'000);
  CHECK(local.wrong == 0);
  CHECK(local.swaps == 0);
  CHECK(run.relay().tool().segments() == 1);
}

TEST_CASE("After a cut, or a relay that was restarted, the copy is the simulation again",
          "[relayed_local]") {
  const auto fault = GENERATE(0, 1, 2);
  RelayedRun run({.link = {.delay = 20, .jitter = 3}, .offset_ns = 12'345'678'901, .period = 33});
  run.go_on(800);
  REQUIRE(first_local(run.felt()) < kBegin + 400);
  if (fault == 0) {
    run.relay().cut(true);
    run.go_on(60);
    run.relay().cut(false);
  } else if (fault == 1) {
    run.relay().restart_simulation_side();
  } else {
    run.relay().restart_hand_side();
  }
  run.go_on(1200);
  INFO("fault " << fault);
  const std::uint64_t again = kBegin + 800 + 60 + 540;
  CHECK(first_local(run.felt()) < again);
  const RelayedRun::Local local = run.local(again);
  CHECK(local.ticks > 400);
  CHECK(local.wrong == 0);
}

}  // namespace stillgrid::scene_relay::relayed_local_test
