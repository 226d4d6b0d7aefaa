#include "shared/tools/scene_relay/ros_source.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::scene_relay::ros_source_test {
namespace {

constexpr std::uint64_t kMs_ns = 1'000'000;
constexpr std::uint64_t kStart_ns = 7'000'000'000'000;

proto::ToolState state_of(std::uint64_t tick, std::uint64_t time_ns) {
  proto::ToolState state{};
  state.time_ns = time_ns;
  state.tick = tick;
  state.orientation_xyzw = {0.0, 0.6, 0.0, 0.8};
  state.before.displayed.alpha = 1.0;
  return state;
}

/// What a look at the segment takes, as the relay looks.
std::optional<proto::ToolState> take(RosSource& source, const publication::ToolView& view,
                                     std::uint64_t now_ns) {
  const auto state = view.read();
  return state && source.takes(view.header(), *state, now_ns) ? state : std::nullopt;
}

/// A loop of 1 kHz, and its segment as a reader sees it.
class Loop {
 public:
  explicit Loop(const publication::TestSession& session, std::uint64_t period_ns = kMs_ns)
      : writer_(session.name(), period_ns, proto::Clock::kMonotonic, 0),
        view_(*publication::SegmentReader::open(session.name(), proto::SegmentKind::kTool,
                                                proto::kToolLayoutHash)) {}

  void publish(const proto::ToolState& state) { writer_.publish(state); }
  [[nodiscard]] const publication::ToolView& view() const { return view_; }

 private:
  publication::ToolWriter writer_;
  publication::ToolView view_;
};

TEST_CASE("Every tick is taken once, however often it is looked for", "[ros_source]") {
  const auto seed = GENERATE(1U, 2U, 3U);
  std::mt19937 random(seed);
  const publication::TestSession session;
  Loop loop(session);
  RosSource source(1000.0);
  CHECK_FALSE(take(source, loop.view(), kStart_ns));  // before the first
  for (std::uint64_t tick = 1; tick <= 300; ++tick) {
    const std::uint64_t time_ns = kStart_ns + tick * kMs_ns + random() % 400'000;
    loop.publish(state_of(tick, time_ns));
    const std::uint64_t looks = random() % 3 + 1;
    for (std::uint64_t look = 0; look < looks; ++look) {
      const auto state = take(source, loop.view(), time_ns + 300'000);
      CHECK(state.has_value() == (look == 0));
      if (state) CHECK(state->tick == tick);
    }
  }
  CHECK(source.counts().taken == 300);
  CHECK(source.counts().missed + source.counts().refused + source.counts().spared == 0);
}

TEST_CASE("Each tick since the first look is taken, spared, refused or missed", "[ros_source]") {
  const auto seed = GENERATE(1U, 2U, 3U, 4U, 5U);
  std::mt19937 random(seed);
  const publication::TestSession session;
  Loop loop(session);
  RosSource source(730.0);
  std::uint64_t first_seen = 0, last_seen = 0;
  for (std::uint64_t tick = 1; tick <= 500; ++tick) {
    proto::ToolState state = state_of(tick, kStart_ns + tick * kMs_ns);
    if (random() % 7 == 0) state.before.torque_N_m[tick % 3] = std::nan("");
    loop.publish(state);
    if (random() % 3 == 0) continue;
    (void)take(source, loop.view(), state.time_ns + 100'000);
    if (first_seen == 0) first_seen = tick;
    last_seen = tick;
  }
  const RosCounts& counts = source.counts();
  CHECK(counts.taken + counts.spared + counts.refused + counts.missed ==
        last_seen - first_seen + 1);
  CHECK(counts.taken > 100);
  CHECK(counts.refused > 10);
  CHECK(counts.missed > 50);
}

TEST_CASE("No more states are taken than the rate asked for, evenly", "[ros_source]") {
  const double rate_hz = GENERATE(1000.0, 700.0, 333.0, 100.0, 7.3);
  const auto seed = GENERATE(1U, 2U, 3U);
  std::mt19937 random(seed);
  const publication::TestSession session;
  Loop loop(session);
  RosSource source(rate_hz);
  std::vector<std::uint64_t> taken_ns;
  constexpr std::uint64_t kTicks = 3000;
  for (std::uint64_t tick = 1; tick <= kTicks; ++tick) {
    const std::uint64_t time_ns = kStart_ns + tick * kMs_ns + random() % 200'000;
    loop.publish(state_of(tick, time_ns));
    if (take(source, loop.view(), time_ns)) taken_ns.push_back(time_ns);
  }
  const double meant = rate_hz * 1e-3 * static_cast<double>(kTicks);
  CHECK(std::abs(static_cast<double>(taken_ns.size()) - meant) <= 2.0);
  const double interval_ns = 1e9 / rate_hz;
  for (std::size_t i = 1; i < taken_ns.size(); ++i)  // within a tick of where it is due
    CHECK(std::abs(static_cast<double>(taken_ns[i] - taken_ns[i - 1]) - interval_ns) < 1.21e6);
}

TEST_CASE("After a pause the ticks that were not come in no burst", "[ros_source]") {
  const publication::TestSession session;
  Loop loop(session);
  RosSource source(100.0);
  std::uint64_t tick = 0;
  const auto taken_of = [&](std::uint64_t from_ms, std::uint64_t to_ms) {
    int count = 0;
    for (std::uint64_t ms = from_ms; ms < to_ms; ++ms) {
      loop.publish(state_of(++tick, kStart_ns + ms * kMs_ns));
      count += take(source, loop.view(), kStart_ns + ms * kMs_ns).has_value() ? 1 : 0;
    }
    return count;
  };
  CHECK(taken_of(0, 100) == 10);
  CHECK(taken_of(5000, 5100) <= 11);
}

TEST_CASE("A figure that is no number is never taken", "[ros_source]") {
  const publication::TestSession session;
  Loop loop(session);
  RosSource source(1000.0);
  std::uint64_t tick = 0;
  const auto is_taken = [&](auto&& spoil) {
    proto::ToolState state = state_of(tick + 1, kStart_ns + (tick + 1) * kMs_ns);
    ++tick;
    spoil(state);
    loop.publish(state);
    return take(source, loop.view(), kStart_ns + tick * kMs_ns + 100'000).has_value();
  };
  REQUIRE(is_taken([](auto&) {}));
  for (const double bad : {std::nan(""), double{INFINITY}, 1e9}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK_FALSE(is_taken([&](auto& state) { state.position_m[axis] = bad; }));
      CHECK_FALSE(is_taken([&](auto& state) { state.force_N[axis] = bad; }));
      CHECK_FALSE(is_taken([&](auto& state) { state.before.torque_N_m[axis] = bad; }));
      CHECK_FALSE(is_taken([&](auto& state) { state.orientation_xyzw[axis] = bad; }));
    }
    CHECK(is_taken([](auto&) {}));
  }
  CHECK_FALSE(is_taken([](auto& state) { state.orientation_xyzw = {}; }));
}

TEST_CASE("What is stamped in the future, long ago or backwards is never taken", "[ros_source]") {
  const publication::TestSession session;
  Loop loop(session);
  RosSource source(1000.0);
  const auto is_taken = [&](std::uint64_t tick, std::uint64_t time_ns, std::uint64_t now_ns) {
    loop.publish(state_of(tick, time_ns));
    return take(source, loop.view(), now_ns).has_value();
  };
  CHECK_FALSE(is_taken(1, kStart_ns + 1, kStart_ns));
  CHECK_FALSE(is_taken(2, kStart_ns, kStart_ns + RosSource::kOldest_ns + 1));
  CHECK_FALSE(is_taken(3, ~std::uint64_t{0}, kStart_ns));
  CHECK(is_taken(4, kStart_ns, kStart_ns + RosSource::kOldest_ns));
  CHECK_FALSE(is_taken(5, kStart_ns, kStart_ns + 1));
  CHECK_FALSE(is_taken(6, kStart_ns - kMs_ns, kStart_ns + 1));
  CHECK(is_taken(7, kStart_ns + kMs_ns, kStart_ns + kMs_ns));
  CHECK_FALSE(is_taken(6, kStart_ns + 2 * kMs_ns, kStart_ns + 2 * kMs_ns));  // a tick back
  CHECK(source.counts().refused == 5);
}

TEST_CASE("The next haptic_server begins anew, and what came between is not missed",
          "[ros_source]") {
  const publication::TestSession session;
  RosSource source(1000.0);
  auto loop = std::make_unique<Loop>(session);
  for (std::uint64_t tick = 1; tick <= 9; ++tick) {
    loop->publish(state_of(tick, kStart_ns + tick * kMs_ns));
    CHECK(take(source, loop->view(), kStart_ns + tick * kMs_ns));
  }
  loop.reset();
  loop = std::make_unique<Loop>(session);
  for (std::uint64_t tick = 3; tick <= 5; ++tick) {
    loop->publish(state_of(tick, kStart_ns + (tick + 500) * kMs_ns));
    CHECK(take(source, loop->view(), kStart_ns + (tick + 500) * kMs_ns));
  }
  CHECK(source.counts().taken == 12);
  CHECK(source.counts().missed == 0);
}

}  // namespace
}  // namespace stillgrid::scene_relay::ros_source_test
