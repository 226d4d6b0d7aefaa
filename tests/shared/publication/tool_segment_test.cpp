#include "shared/publication/tool_segment.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::tool_segment_test {
namespace {

ToolView view_of(const TestSession& session) {
  auto reader =
      SegmentReader::open(session.name(), proto::SegmentKind::kTool, proto::kToolLayoutHash);
  REQUIRE(reader);
  return ToolView(std::move(*reader));
}

proto::ToolState sound_state() {
  return {.time_ns = 7'000'000,
          .tick = 7,
          .path_number = 6,
          .position_m = {0.01, -0.02, 0.03},
          .orientation_xyzw = {0.0, 0.6, 0.0, 0.8},
          .velocity_m_s = {0.1, 0.2, -0.3},
          .force_N = {0.0, 1.5, 0.0},
          .buttons = 2,
          .before = {.torque_N_m = {0.01, 0.0, -0.02},
                     .contacts = 3,
                     .flags = proto::kFlagSlewed,
                     .work_ns = 12'000,
                     .wake_up_latency_ns = 40'000,
                     .missed_ticks = 1,
                     .displayed = {.scene_epoch = 77,
                                   .snapshot_id = 9,
                                   .alpha = 0.5,
                                   .age_s = 0.03,
                                   .local_ticks = 3,
                                   .is_local = 1}},
          .device = {}};
}

TEST_CASE("The simulation reads the tool as the haptic server published it", "[tool_segment]") {
  const TestSession session;
  ToolWriter writer(session.name(), 1'000'000, proto::Clock::kVirtual, 0);
  const ToolView view = view_of(session);
  CHECK_FALSE(view.read());

  const proto::ToolState state = sound_state();
  writer.publish(state);
  const auto read = view.read();

  REQUIRE(read);
  CHECK(std::memcmp(&*read, &state, sizeof state) == 0);
  CHECK(view.header().period_ns == 1'000'000);
  CHECK(view.header().clock == proto::Clock::kVirtual);
  CHECK(view.reader().live().heartbeat_ns == state.time_ns);
}

TEST_CASE("Only the newest state of the tool is read", "[tool_segment]") {
  const TestSession session;
  ToolWriter writer(session.name(), 1'000'000, proto::Clock::kVirtual, 0);
  const ToolView view = view_of(session);
  proto::ToolState state = sound_state();
  for (state.tick = 1; state.tick < 5; ++state.tick) writer.publish(state);

  REQUIRE(view.read());
  CHECK(view.read()->tick == 4);
}

TEST_CASE("A state that is no pose or holds no numbers is as if there were none",
          "[tool_segment]") {
  const TestSession session;
  ToolWriter writer(session.name(), 1'000'000, proto::Clock::kVirtual, 0);
  const ToolView view = view_of(session);
  const auto is_read = [&](auto&& spoil) {
    proto::ToolState state = sound_state();
    spoil(state);
    writer.publish(state);
    return view.read().has_value();
  };

  REQUIRE(is_read([](auto&) {}));
  for (const double bad : {std::nan(""), double{INFINITY}, -double{INFINITY}})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK_FALSE(is_read([&](auto& state) { state.position_m[axis] = bad; }));
      CHECK_FALSE(is_read([&](auto& state) { state.velocity_m_s[axis] = bad; }));
      CHECK_FALSE(is_read([&](auto& state) { state.force_N[axis] = bad; }));
      CHECK_FALSE(is_read([&](auto& state) { state.orientation_xyzw[axis] = bad; }));
    }
  CHECK_FALSE(is_read([](auto& state) { state.orientation_xyzw = {0.0, 0.0, 0.0, 0.0}; }));
  CHECK_FALSE(is_read([](auto& state) { state.orientation_xyzw = {0.0, 0.0, 0.0, 1.1}; }));
}

TEST_CASE("A state of the tool out of all proportion is as if there were none", "[tool_segment]") {
  const TestSession session;
  ToolWriter writer(session.name(), 1'000'000, proto::Clock::kVirtual, 0);
  const ToolView view = view_of(session);
  const auto is_read = [&](double number) {
    bool read = false;
    for (auto numbers : {&proto::ToolState::position_m, &proto::ToolState::velocity_m_s,
                         &proto::ToolState::force_N}) {
      proto::ToolState state = sound_state();
      (state.*numbers)[1] = number;
      writer.publish(state);
      read = read || view.read();
    }
    return read;
  };

  CHECK(is_read(-proto::kLargestNumber));
  for (const double number : {1.1e6, -1e9, 1e300, 1e308}) CHECK_FALSE(is_read(number));
}

TEST_CASE("Figures of a tick that are none, or flags that nobody knows, are not shown",
          "[tool_segment]") {
  const auto is_shown = [](auto&& spoil) {
    proto::ToolState state = sound_state();
    spoil(state.before);
    return has_sound_figures(state);
  };
  REQUIRE(is_shown([](auto&) {}));
  for (const double bad : {std::nan(""), double{INFINITY}, -1.1e6}) {
    CHECK_FALSE(is_shown([&](auto& tick) { tick.torque_N_m[1] = bad; }));
    CHECK_FALSE(is_shown([&](auto& tick) { tick.displayed.alpha = bad; }));
    CHECK_FALSE(is_shown([&](auto& tick) { tick.displayed.age_s = bad; }));
  }
  CHECK_FALSE(is_shown([](auto& tick) { tick.displayed.alpha = 1.1; }));
  CHECK_FALSE(is_shown([](auto& tick) { tick.displayed.is_local = 2; }));
  CHECK(is_shown([](auto& tick) { tick.flags = proto::kSafetyFlagMask; }));
  CHECK_FALSE(is_shown([](auto& tick) { tick.flags = proto::kSafetyFlagMask + 1; }));
}

TEST_CASE("A tool segment whose slots cannot hold a tool state is refused", "[tool_segment]") {
  const TestSession session;
  SegmentSpec spec = small_spec(proto::SegmentKind::kTool);
  spec.layout_hash = proto::kToolLayoutHash;
  spec.fixed_bytes = sizeof(proto::SegmentHeader) + sizeof(proto::ToolPath);
  spec.payload_bytes = sizeof(proto::ToolState) - 8;
  SegmentWriter writer(session.name(), spec);
  writer.announce();

  CHECK(refusal_of([&] { static_cast<void>(view_of(session)); }).find("too small") !=
        std::string::npos);
}

}  // namespace
}  // namespace stillgrid::publication::tool_segment_test
