#include "shared/tools/scene_relay/ros_messages.hpp"

#include <array>
#include <ctime>
#include <limits>

#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::scene_relay {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::uint64_t wall_clock_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<std::uint64_t>(now.tv_sec * kSecond_ns + now.tv_nsec);
}

std_msgs_msg_dds__Header_ header_of(RosStamp stamp, const std::string& frame) noexcept {
  // The C type has no const; writing only reads.
  return {.stamp_ = stamp, .frame_id_ = const_cast<char*>(frame.c_str())};
}

geometry_msgs_msg_dds__Vector3_ vector_of(const std::array<double, 3>& xyz) noexcept {
  return {.x_ = xyz[0], .y_ = xyz[1], .z_ = xyz[2]};
}

}  // namespace

ClockPair read_clocks() noexcept {
  ClockPair best;
  std::uint64_t narrowest_ns = std::numeric_limits<std::uint64_t>::max();
  for (int attempt = 0; attempt < 3; ++attempt) {
    const std::uint64_t before_ns = realtime::monotonic_ns();
    const std::uint64_t wall_ns = wall_clock_ns();
    const std::uint64_t width_ns = realtime::monotonic_ns() - before_ns;
    if (width_ns >= narrowest_ns) continue;
    narrowest_ns = width_ns;
    best = {.monotonic_ns = before_ns + width_ns / 2, .wall_ns = wall_ns};
  }
  return best;
}

std::optional<RosStamp> ros_stamp(std::uint64_t time_ns, const ClockPair& now) noexcept {
  // Unsigned, so that a stamp from anywhere wraps instead of overflowing.
  const auto wall_ns = static_cast<std::int64_t>(now.wall_ns + (time_ns - now.monotonic_ns));
  if (wall_ns < 0 || wall_ns / kSecond_ns > std::numeric_limits<std::int32_t>::max())
    return std::nullopt;
  return RosStamp{.sec_ = static_cast<std::int32_t>(wall_ns / kSecond_ns),
                  .nanosec_ = static_cast<std::uint32_t>(wall_ns % kSecond_ns)};
}

RosPose pose_message(const proto::ToolState& state, RosStamp stamp,
                     const std::string& frame) noexcept {
  const std::array<double, 3>& position = state.position_m;
  const std::array<double, 4>& q = state.orientation_xyzw;
  return {.header_ = header_of(stamp, frame),
          .pose_ = {.position_ = {.x_ = position[0], .y_ = position[1], .z_ = position[2]},
                    .orientation_ = {.x_ = q[0], .y_ = q[1], .z_ = q[2], .w_ = q[3]}}};
}

RosWrench wrench_message(const proto::ToolState& state, RosStamp stamp,
                         const std::string& frame) noexcept {
  return {.header_ = header_of(stamp, frame),
          .wrench_ = {.force_ = vector_of(state.force_N),
                      .torque_ = vector_of(state.before.torque_N_m)}};
}

}  // namespace stillgrid::scene_relay
