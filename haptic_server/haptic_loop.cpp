#include "haptic_server/haptic_loop.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid {
namespace {

constexpr double to_s(std::uint64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

Eigen::Quaterniond quaternion(const double (&xyzw)[4]) {
  return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}
Eigen::Quaterniond quaternion(const std::array<double, 4>& xyzw) {
  return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}
std::array<double, 3> array(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

bool has_position(const stillgrid_device_state& state) {
  const auto& p = state.position_m;
  return (state.valid & STILLGRID_STATE_POSITION) != 0 && std::isfinite(p[0]) &&
         std::isfinite(p[1]) && std::isfinite(p[2]);
}

bool has_orientation(const stillgrid_device_state& state) {
  return (state.valid & STILLGRID_STATE_ORIENTATION) != 0 &&
         std::abs(quaternion(state.orientation_xyzw).squaredNorm() - 1.0) < 1e-3;
}

/// How far the tool's farthest point is from its origin.
double lever_m(const proto::SceneHeader& scene) {
  double farthest_m = 0.0;
  for (std::uint32_t i = 0; i < scene.tool_sphere_count; ++i) {
    const auto& [position_m, radius_m] = scene.tool[i];
    const Eigen::Vector3d centre_m(position_m[0], position_m[1], position_m[2]);
    farthest_m = std::max(farthest_m, centre_m.norm() + radius_m);
  }
  return farthest_m;
}

}  // namespace

TickEnd HapticLoop::sense(const SceneView& scene, std::uint64_t now_ns) noexcept {
  if (++tick_ == 1) start_ns_ = now_ns;
  flags_ = 0;
  stillgrid_device_state state{};
  device_code_ = device_.read(now_ns, state);
  if (device_code_ == STILLGRID_DEVICE_END) return TickEnd::kDeviceEnd;
  if (device_code_ != STILLGRID_DEVICE_OK) return TickEnd::kDeviceFault;

  const proto::DeviceFrame& frame = scene.scene().device;
  const Eigen::Quaterniond turn = quaternion(frame.orientation_xyzw);
  motion_ = {};
  if (has_position(state)) {
    const Eigen::Vector3d device_m(state.position_m);
    if (has_pose_) motion_.moved_m = turn * (device_m - device_m_);
    device_m_ = device_m;
    has_pose_ = true;
    pose_.position_m = Eigen::Vector3d(frame.position_m.data()) + frame.scale * (turn * device_m);
    pose_.velocity_m_s = velocity_.update(now_ns, pose_.position_m);
    if (has_orientation(state)) {
      const Eigen::Quaterniond before = pose_.orientation;
      pose_.orientation = (turn * quaternion(state.orientation_xyzw)).normalized();
      if (has_orientation_)
        motion_.turned_rad = rotation_rad(pose_.orientation * before.conjugate());
      has_orientation_ = true;
    }
    pose_.angular_velocity_rad_s = angular_velocity_.update(now_ns, pose_.orientation);
  } else {
    flags_ |= kFlagBadDevice;
  }
  if (!has_pose_) return TickEnd::kGoOn;  // nothing to show the simulation yet

  const Eigen::Quaterniond& q = pose_.orientation;
  tool_.publish({.time_ns = now_ns,
                 .tick = tick_,
                 .position_m = array(pose_.position_m),
                 .orientation_xyzw = {q.x(), q.y(), q.z(), q.w()},
                 .velocity_m_s = array(pose_.velocity_m_s),
                 .force_N = array(held_.force_N),
                 .buttons = (state.valid & STILLGRID_STATE_BUTTONS) != 0 ? state.buttons : 0U});
  return TickEnd::kGoOn;
}

TickEnd HapticLoop::act(const SceneView& scene, bool writer_alive, std::uint64_t now_ns,
                        TickRow& row) noexcept {
  rendered_ = has_pose_ ? renderer_->render(scene, pose_, now_ns) : RenderedTick{};
  if (rendered_.contended) flags_ |= kFlagContended;
  if (rendered_.cut) flags_ |= kFlagCut;
  if (rendered_.swept) flags_ |= kFlagSwept;
  Wrench asked{rendered_.force.force_N, rendered_.force.torque_N_m};
  observe(energy_, held_, motion_);
  const bool exists = rendered_.generation != 0 && (flags_ & kFlagBadDevice) == 0;
  if (passivity_control_ && exists)
    asked.force_N += passivity_control_->damp(energy_, motion_, to_s(period_ns_), flags_);
  held_before_N_ = held_.force_N;
  held_ = guard_.apply(asked, lever_m(scene.scene()),
                       {.exists = exists,
                        .image_age_s = rendered_.image_age_s,
                        .period_s = to_s(scene.header().period_ns),
                        .writer_alive = writer_alive},
                       to_s(period_ns_), flags_);
  const Eigen::Quaterniond turn = quaternion(scene.scene().device.orientation_xyzw);
  device_code_ =
      device_.write(now_ns, turn.conjugate() * held_.force_N, turn.conjugate() * held_.torque_N_m);

  row = {.time_s = to_s(now_ns - start_ns_),
         .position_m = pose_.position_m,
         .velocity_m_s = pose_.velocity_m_s,
         .force_N = held_.force_N,
         .rendered_N = rendered_.force.force_N,
         .generation = rendered_.generation,
         .alpha = rendered_.alpha,
         .contacts = rendered_.force.contacts,
         .age_s = rendered_.age_s,
         .tick_ns = 0,
         .flags = flags_,
         .torque_N_m = held_.torque_N_m};
  return device_code_ == STILLGRID_DEVICE_OK ? TickEnd::kGoOn : TickEnd::kDeviceFault;
}

void HapticLoop::count(const TickRow& row, HapticReport& report) noexcept {
  count_tick(report, row, rendered_, held_before_N_, motion_.moved_m, to_s(period_ns_));
  report.energy = energy_;
  if (rendered_.is_new) ++report.snapshots;
}

}  // namespace stillgrid
