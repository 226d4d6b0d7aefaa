#include "shared/tools/scene_relay/ros_messages.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::scene_relay::ros_messages_test {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

std::uint64_t ns_of(const RosStamp& stamp) {
  return static_cast<std::uint64_t>(stamp.sec_) * kSecond_ns + stamp.nanosec_;
}

TEST_CASE("A stamp of ROS is as long ago by the wall as by the haptic clock", "[ros_messages]") {
  const auto seed = GENERATE(1U, 2U, 3U, 4U, 5U);
  std::mt19937_64 random(seed);
  for (int draw = 0; draw < 200; ++draw) {
    const ClockPair now{
        .monotonic_ns = random() % (kSecond_ns * 86400 * 1000),
        .wall_ns = 1'700'000'003'141'592'653 + random() % (300'000'000 * kSecond_ns)};
    const std::uint64_t age_ns = random() % std::min(now.monotonic_ns, std::uint64_t{1} << 40U);
    const auto stamp = ros_stamp(now.monotonic_ns - age_ns, now);

    REQUIRE(stamp);
    CHECK(now.wall_ns - ns_of(*stamp) == age_ns);
    CHECK(stamp->nanosec_ < kSecond_ns);
  }
}

TEST_CASE("A time that ROS cannot write has no stamp", "[ros_messages]") {
  const ClockPair now{.monotonic_ns = 5 * kSecond_ns, .wall_ns = 4 * kSecond_ns};
  CHECK(ros_stamp(kSecond_ns, now));  // 1970, to the second
  CHECK_FALSE(ros_stamp(kSecond_ns - 1, now));
  const std::uint64_t last_s = 0x7FFFFFFF;
  const ClockPair late{.monotonic_ns = 0, .wall_ns = last_s * kSecond_ns};
  CHECK(ros_stamp(kSecond_ns - 1, late));
  CHECK_FALSE(ros_stamp(kSecond_ns, late));
}

TEST_CASE("Both clocks are read at one moment", "[ros_messages]") {
  const std::uint64_t before_ns = realtime::monotonic_ns();
  const ClockPair pair = read_clocks();
  CHECK(pair.monotonic_ns >= before_ns);
  CHECK(pair.monotonic_ns <= realtime::monotonic_ns());
  CHECK(pair.wall_ns > 1'600'000'000 * kSecond_ns);  // past 2020
}

TEST_CASE("Messages tell the tool's pose, and force and torque on the hand", "[ros_messages]") {
  proto::ToolState state{};
  state.position_m = {0.017, -0.023, 0.031};
  state.orientation_xyzw = {0.1, 0.3, -0.9, 0.3};
  state.force_N = {-1.25, 2.5, 0.75};
  state.before.torque_N_m = {0.011, -0.013, 0.017};
  const std::string frame = "stillgrid/demo";
  const RosStamp stamp{.sec_ = 17, .nanosec_ = 999'999'999};
  const RosPose pose = pose_message(state, stamp, frame);
  const RosWrench wrench = wrench_message(state, stamp, frame);

  for (const std_msgs_msg_dds__Header_& header : {pose.header_, wrench.header_}) {
    CHECK(ns_of(header.stamp_) == 17'999'999'999);
    CHECK(frame == header.frame_id_);
  }
  const auto& at = pose.pose_.position_;
  CHECK(std::array{at.x_, at.y_, at.z_} == state.position_m);
  const auto& turned = pose.pose_.orientation_;
  CHECK(std::array{turned.x_, turned.y_, turned.z_, turned.w_} == state.orientation_xyzw);
  const auto& force_N = wrench.wrench_.force_;
  CHECK(std::array{force_N.x_, force_N.y_, force_N.z_} == state.force_N);
  const auto& torque_N_m = wrench.wrench_.torque_;
  CHECK(std::array{torque_N_m.x_, torque_N_m.y_, torque_N_m.z_} == state.before.torque_N_m);
}

}  // namespace
}  // namespace stillgrid::scene_relay::ros_messages_test
