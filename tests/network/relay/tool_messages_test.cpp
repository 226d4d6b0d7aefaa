#include "shared/tools/scene_relay/tool_messages.hpp"

#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "shared/tools/scene_relay/sequence.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::scene_relay::tool_messages_test {
namespace {

proto::ToolState state_at(std::uint64_t n) {
  proto::ToolState state{};
  state.time_ns = n * proto::kPathTick_ns + 123;
  state.tick = n;
  state.path_number = n;
  state.position_m = {1e-4 * static_cast<double>(n), 0.2, -0.3};
  state.orientation_xyzw = {0.0, 0.6, 0.0, 0.8};
  state.velocity_m_s = {0.1, 0.0, 1e-5 * static_cast<double>(n)};
  return state;
}

struct MessageBed {
  publication::TestSession session;
  publication::ToolWriter writer{session.name(), 1'000'000, proto::Clock::kMonotonic, 0};
  publication::ToolView view{*publication::SegmentReader::open(
      session.name(), proto::SegmentKind::kTool, proto::kToolLayoutHash)};
  ToolMessages messages{7};
};

}  // namespace

TEST_CASE("Each tick of the path is in twelve messages, as it is on the path", "[tool_messages]") {
  MessageBed bed;
  std::multiset<std::uint64_t> sent;
  for (std::uint64_t n = 1'000; n < 3'000; ++n) {
    bed.writer.publish(state_at(n));
    const ToolMessage& message = bed.messages.encode(bed.view, state_at(n), true);
    CHECK(message.path_number == n);
    CHECK(message_bytes(message) <= ToolMessages::kPacket_bytes);
    for (const PathSample& sample : elements(message.path)) {
      sent.insert(sample.number);
      const proto::ToolState state = state_at(sample.number);
      REQUIRE(std::to_array(sample.position_m) == state.position_m);
      REQUIRE(std::to_array(sample.orientation_xyzw) == state.orientation_xyzw);
      REQUIRE(std::to_array(sample.velocity_m_s) == state.velocity_m_s);
    }
    CHECK(elements(message.path).back().number == n);
  }
  for (std::uint64_t n = 1'000; n < 2'980; ++n) REQUIRE(sent.count(n) == 12);
}

TEST_CASE("A relay that was held up sends the ticks that it has not sent, up to 64",
          "[tool_messages]") {
  MessageBed bed;
  std::mt19937 random(GENERATE(1U, 2U, 3U));
  std::uint64_t n = 1'000, last = 999;
  for (int round = 0; round < 200; ++round) {
    const std::uint64_t held_up = 1 + random() % 100;
    for (std::uint64_t i = 0; i < held_up; ++i) bed.writer.publish(state_at(n++));
    const ToolMessage& message = bed.messages.encode(bed.view, state_at(n - 1), true);
    const auto path = elements(message.path);
    REQUIRE(path.size() <= 64);
    REQUIRE(path.back().number == n - 1);
    REQUIRE(path.back().number - path.front().number + 1 == path.size());
    if (held_up <= 64) CHECK(path.front().number <= last + 1);
    last = n - 1;
  }
}

TEST_CASE("Without a model no path is sent", "[tool_messages]") {
  MessageBed bed;
  bed.writer.publish(state_at(5));
  CHECK(bed.messages.encode(bed.view, state_at(5), false).path._length == 0);
}

}  // namespace stillgrid::scene_relay::tool_messages_test
