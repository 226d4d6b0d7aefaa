#include "shared/tools/scene_relay/shown_tool.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <limits>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "shared/tools/scene_relay/deadband.hpp"
#include "shared/tools/scene_relay/sequence.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::scene_relay::shown_tool_test {
namespace {

constexpr std::uint64_t kMs_ns = 1'000'000, kPatience_ns = 250'000'000;
constexpr std::uint64_t kHandsStart_ns = 987'654'321'987'654;  // its clock is days ahead

/// Of a link of 2 ms either way.
ClockOffset known_clock(std::uint64_t now_ns) {
  ClockOffset clock;
  for (std::uint64_t i = 0; i < 5; ++i) {
    const std::uint64_t sent_ns = now_ns + i * 100 * kMs_ns;
    const std::uint64_t there_ns = kHandsStart_ns + sent_ns + 2 * kMs_ns;
    REQUIRE(clock.add({sent_ns, there_ns, there_ns, sent_ns + 4 * kMs_ns}));
  }
  return clock;
}

ToolMessage sample(std::uint64_t now_ns, double x_m = 0.0, double vx_m_s = 0.0) {
  ToolMessage message{};
  message.segment_epoch = 77;
  message.period_ns = kMs_ns;
  message.time_ns = kHandsStart_ns + now_ns - 2 * kMs_ns;
  message.path_number = message.time_ns / proto::kPathTick_ns;
  message.position_m[0] = x_m;
  message.orientation_xyzw[3] = 1.0;
  message.velocity_m_s[0] = vx_m_s;
  return message;
}

class ToolBed {
 public:
  [[nodiscard]] ShownTool& tool() noexcept { return tool_; }
  [[nodiscard]] const ClockOffset& clock() const noexcept { return clock_; }
  [[nodiscard]] ShownTool::Shown show(const ToolMessage& message, std::uint64_t now_ns) {
    return tool_.show(message, clock_, now_ns);
  }
  /// What a simulation reads.
  [[nodiscard]] std::optional<publication::ToolView> view() const {
    auto reader = publication::SegmentReader::open(session_.name(), proto::SegmentKind::kTool,
                                                   proto::kToolLayoutHash);
    if (!reader) return std::nullopt;
    return publication::ToolView(std::move(*reader));
  }
  [[nodiscard]] std::optional<proto::ToolState> read() const {
    const auto tool = view();
    return tool ? tool->read() : std::nullopt;
  }
  /// Another exchange with the hand, whose clock is ahead by that; a link of 2 ms either way.
  void learn(std::uint64_t now_ns, std::int64_t ahead_ns) {
    const std::uint64_t there_ns = now_ns - 2 * kMs_ns + static_cast<std::uint64_t>(ahead_ns);
    REQUIRE(clock_.add({now_ns - 4 * kMs_ns, there_ns, there_ns, now_ns}));
  }

 private:
  publication::TestSession session_;
  ClockOffset clock_ = known_clock(10'000 * kMs_ns);
  ShownTool tool_{session_.name(), std::nullopt};
};

constexpr std::uint64_t kBegin_ns = 11'000 * kMs_ns;

}  // namespace

TEST_CASE("A sample's stamp comes back to the hand to the bit, and its times here only grow") {
  std::mt19937_64 random(GENERATE(3U, 5U, 7U, 11U, 13U, 17U, 19U, 23U));
  ToolBed bed;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> shown;  // here, at the hand
  std::uint64_t now_ns = kBegin_ns, before_ns = 0;
  for (int i = 0; i < 3000; ++i) {
    now_ns += kMs_ns - 300'000 + random() % 600'000;
    ToolMessage message = sample(now_ns, 1e-5 * i);
    message.time_ns -= random() % (3 * kMs_ns);  // on its way for 2 to 5 ms
    message.path_number = message.time_ns / kMs_ns;
    REQUIRE(bed.show(message, now_ns) == ShownTool::Shown::kShown);
    const auto state = bed.read();
    REQUIRE(state);
    CHECK(state->time_ns > before_ns);
    before_ns = state->time_ns;
    shown.emplace_back(state->time_ns, message.time_ns);
  }
  for (const auto& [here_ns, hands_ns] : shown)
    REQUIRE(bed.tool().on_hands_clock(here_ns) == hands_ns);
  CHECK(bed.tool().on_hands_clock(0) == 0);
  CHECK(bed.tool().on_hands_clock(before_ns + 1) == 0);
}

TEST_CASE("A sample whose successors are kept back is led on for 50 ms, and joins no account") {
  ToolBed bed;
  ToolMessage message = sample(kBegin_ns, 0.01, 0.2);
  message.is_led_on = true;
  REQUIRE(bed.show(message, kBegin_ns) == ShownTool::Shown::kShown);
  const auto sent = bed.read();
  REQUIRE(sent);
  for (std::uint64_t ms = 1; ms < 200; ++ms) {
    bed.tool().look(kBegin_ns + ms * kMs_ns, kPatience_ns);
    const auto state = bed.read();
    REQUIRE(state);
    const double led_s = 1e-3 * static_cast<double>(std::min<std::uint64_t>(ms, 50));
    CHECK(state->position_m[0] == Approx(0.01 + 0.2 * led_s).margin(1e-9));
    CHECK(state->time_ns == sent->time_ns + ms * kMs_ns);
    CHECK(bed.tool().on_hands_clock(state->time_ns) == 0);
  }
  CHECK(bed.read()->velocity_m_s[0] == 0.0);
  bed.tool().look(kBegin_ns + kPatience_ns, kPatience_ns);
  CHECK_FALSE(bed.read());
}

TEST_CASE("A sample that is the last for now stays where it is, and the tool of a silence ends") {
  ToolBed bed;
  REQUIRE(bed.show(sample(kBegin_ns, 0.01, 0.2), kBegin_ns) == ShownTool::Shown::kShown);
  for (std::uint64_t ms = 1; ms < 250; ++ms) {
    bed.tool().look(kBegin_ns + ms * kMs_ns, kPatience_ns);
    REQUIRE(bed.read());
    CHECK(bed.read()->position_m[0] == 0.01);
  }
  bed.tool().look(kBegin_ns + kPatience_ns, kPatience_ns);
  CHECK_FALSE(bed.read());
  // It comes back with the next sample.
  const std::uint64_t later_ns = kBegin_ns + 3000 * kMs_ns;
  REQUIRE(bed.show(sample(later_ns, 0.03), later_ns) == ShownTool::Shown::kShown);
  CHECK(bed.read()->position_m[0] == 0.03);
  CHECK(bed.tool().segments() == 2);
}

TEST_CASE("Another haptic_server is another writer from its second sample on") {
  ToolBed bed;
  REQUIRE(bed.show(sample(kBegin_ns, 0.01), kBegin_ns) == ShownTool::Shown::kShown);
  ToolMessage other = sample(kBegin_ns + kMs_ns, 0.02);
  other.segment_epoch = 78;
  CHECK(bed.show(other, kBegin_ns + kMs_ns) == ShownTool::Shown::kWaits);
  CHECK(bed.read()->position_m[0] == 0.01);
  other.time_ns += kMs_ns;
  CHECK(bed.show(other, kBegin_ns + 2 * kMs_ns) == ShownTool::Shown::kShown);
  CHECK(bed.read()->position_m[0] == 0.02);
  CHECK(bed.tool().segments() == 2);
}

TEST_CASE("A sample with a number that cannot be is refused, whichever it is") {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {kNone, 1e30, -std::numeric_limits<double>::infinity()}) {
    ToolBed bed;
    for (const auto field : {&ToolMessage::position_m, &ToolMessage::velocity_m_s,
                             &ToolMessage::force_N, &ToolMessage::torque_N_m}) {
      ToolMessage message = sample(kBegin_ns);
      (message.*field)[1] = bad;
      CHECK(bed.show(message, kBegin_ns) == ShownTool::Shown::kRefused);
    }
    ToolMessage turned = sample(kBegin_ns);
    turned.orientation_xyzw[2] = bad;
    CHECK(bed.show(turned, kBegin_ns) == ShownTool::Shown::kRefused);
    CHECK_FALSE(bed.read());
  }
  ToolBed bed;
  ToolMessage flagged = sample(kBegin_ns), hasty = sample(kBegin_ns);
  flagged.flags = 1U << 31U;
  hasty.period_ns = 1;
  CHECK(bed.show(flagged, kBegin_ns) == ShownTool::Shown::kRefused);
  CHECK(bed.show(hasty, kBegin_ns) == ShownTool::Shown::kRefused);
}

namespace {

/// A message with a path of ten ticks, the last one the state's.
struct PathMessage {
  explicit PathMessage(std::uint64_t now_ns) : message(sample(now_ns)) {
    for (std::uint64_t i = 0; i < 10; ++i) {
      PathSample& of_tick = path.emplace_back();
      of_tick.number = message.path_number - 9 + i;
      of_tick.position_m[1] = 1e-3 * static_cast<double>(of_tick.number % 1000);
      of_tick.orientation_xyzw[3] = 1.0;
    }
    point_to(message.path, path);
  }
  std::vector<PathSample> path;
  ToolMessage message;
};

}  // namespace

TEST_CASE("The path here is the hand's, moved by a whole number of ticks to the present") {
  ToolBed bed;
  for (std::uint64_t ms = 0; ms < 100; ms += 7) {  // six of seven messages are lost
    const std::uint64_t now_ns = kBegin_ns + ms * kMs_ns + 400'000;
    REQUIRE(bed.show(PathMessage(now_ns).message, now_ns) == ShownTool::Shown::kShown);
    const auto view = bed.view();
    REQUIRE(view);
    const std::uint64_t newest = view->path().newest().value();
    CHECK(newest == view->read()->path_number);
    // Nothing is ahead of the simulation's clock, nor later than it can be.
    CHECK(newest <= now_ns / kMs_ns);
    CHECK(newest + 1 >= now_ns / kMs_ns);
    const PathMessage told(now_ns);
    for (std::uint64_t n = newest - 9 - (ms > 0 ? 7 : 0); n <= newest; ++n) {
      const auto here = view->path().sample(n);
      REQUIRE(here);
      const std::uint64_t hands = bed.tool().hands_number(n).value();
      CHECK(here->position_m[1] == 1e-3 * static_cast<double>(hands % 1000));
    }
    CHECK(bed.tool().hands_number(newest) == told.message.path_number);
  }
}

TEST_CASE("A path with a number or a pose that cannot be is refused") {
  ToolBed bed;
  const auto is_refused = [&](auto&& spoil) {
    PathMessage told(kBegin_ns);
    spoil(told.message, told.path);
    return bed.show(told.message, kBegin_ns) == ShownTool::Shown::kRefused;
  };
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  CHECK(is_refused([](auto&, auto& path) { path[3].position_m[1] = kNone; }));
  CHECK(is_refused([](auto&, auto& path) { path[3].velocity_m_s[2] = 1e30; }));
  CHECK(is_refused([](auto&, auto& path) { path[3].orientation_xyzw[0] = 0.5; }));
  CHECK(is_refused([](auto&, auto& path) { path[3].number = path[2].number; }));
  CHECK(is_refused([](auto&, auto& path) { std::swap(path[3], path[4]); }));
  CHECK(is_refused([](auto&, auto& path) { path[9].number += 1; }));
  CHECK(is_refused([](auto&, auto& path) { path[9].number = proto::kNever; }));
  CHECK(is_refused([](auto&, auto& path) { path[0].number = 0; }));
  for (const std::int64_t by : {2L, 4'098L, -5'000L, -(1L << 62U)}) {
    CHECK(is_refused([by](auto& message, auto& path) {
      message.path_number += static_cast<std::uint64_t>(by);
      for (PathSample& of_tick : path) of_tick.number += static_cast<std::uint64_t>(by);
    }));
  }
  CHECK_FALSE(bed.read());
  CHECK_FALSE(is_refused([](auto&, auto&) {}));
  CHECK(bed.read());
}

TEST_CASE("Numbers stay while clocks drift apart by 50 ticks; then another segment begins") {
  ToolBed bed;
  std::uint64_t now_ns = kBegin_ns;
  REQUIRE(bed.show(sample(now_ns), now_ns) == ShownTool::Shown::kShown);
  const std::uint64_t first = bed.tool().hands_number(20'000).value();
  bool was_moved = false;
  // The hand's clock gains 1e-4: after 500 s it is 50 ms ahead.
  for (std::uint64_t s = 1; s < 560; ++s) {
    now_ns = kBegin_ns + s * 1'000 * kMs_ns;
    const auto gained_ns = static_cast<std::int64_t>(s * 100'000);
    bed.learn(now_ns, static_cast<std::int64_t>(kHandsStart_ns) + gained_ns);
    ToolMessage message = sample(now_ns);
    message.time_ns += static_cast<std::uint64_t>(gained_ns);
    message.path_number = message.time_ns / kMs_ns;
    REQUIRE(bed.show(message, now_ns) == ShownTool::Shown::kShown);
    if (s < 490) CHECK(bed.tool().hands_number(20'000) == first);
    was_moved = was_moved || bed.tool().hands_number(20'000) != first;
    // The simulation's clock is never farther than that from the path.
    const auto late = static_cast<std::int64_t>(now_ns / kMs_ns) -
                      static_cast<std::int64_t>(bed.read()->path_number);
    CHECK(std::abs(late) <= ShownTool::kLongestDrift + 1);
  }
  CHECK(was_moved);
  CHECK(bed.tool().segments() == 2);
}

}  // namespace stillgrid::scene_relay::shown_tool_test
