#include "haptic_server/haptic_loop.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "shared/realtime/flush_denormals.hpp"

namespace stillgrid::haptic_server {
namespace {

constexpr double to_s(std::uint64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

Eigen::Quaterniond quaternion(const std::array<double, 4>& xyzw) {
  return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}
std::array<double, 3> array(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

/// The tool where the device says it is, and how it came there.
void HapticLoop::place(const proto::DeviceFrame& frame,
                       const safety::DeviceReading& reading) noexcept {
  const Eigen::Quaterniond turn = quaternion(frame.orientation_xyzw);
  const double last_scale = placement_.scale(),
               asked = orders_ ? orders_->scale.load() : last_scale;
  // In contact another scale would change the stiffness that is felt, and so give energy.
  const bool is_felt = !held_.force_N.isZero(0.0) || !held_.torque_N_m.isZero(0.0);
  const double scale = is_felt ? last_scale : asked;
  if (scale != last_scale) velocity_ = {};  // it remembers ways of the other scale
  scale_ = frame.scale * scale;
  is_held_ = orders_ != nullptr && orders_->holds_tool(reading.buttons);
  if (has_pose_) motion_.moved_m = turn * (reading.position_m - device_m_);
  device_m_ = reading.position_m;
  has_pose_ = true;
  pose_.position_m = placement_.place(frame, device_m_, is_held_, scale);
  pose_.velocity_m_s = velocity_.update(reading.time_ns, pose_.position_m);
  if (reading.orientation) {
    const Eigen::Quaterniond before = pose_.orientation;
    pose_.orientation = (turn * *reading.orientation).normalized();
    if (has_orientation_)
      motion_.turned_rad = rendering::rotation_rad(pose_.orientation * before.conjugate());
    has_orientation_ = true;
  }
  pose_.angular_velocity_rad_s = angular_velocity_.update(reading.time_ns, pose_.orientation);
}

void HapticLoop::note_device(const stillgrid_device_state& state) noexcept {
  constexpr double kHottest_C = 1e3;
  told_.told = 0;
  told_.status = state.status;
  told_.status_known = state.status_known;
  if ((state.valid & STILLGRID_STATE_TEMPERATURE) != 0 &&
      std::abs(state.temperature_C) <= kHottest_C) {
    told_.told |= STILLGRID_STATE_TEMPERATURE;
    told_.temperature_C = static_cast<float>(state.temperature_C);
    temperature_C_ = state.temperature_C;
  }
  if ((state.valid & STILLGRID_STATE_GRIPPER) != 0 && std::abs(state.gripper_m) <= 1.0) {
    told_.told |= STILLGRID_STATE_GRIPPER;
    told_.gripper_m = state.gripper_m;
  }
  if ((state.valid & STILLGRID_STATE_AXES) == 0) return;
  told_.told |= STILLGRID_STATE_AXES;
  for (std::size_t i = 0; i < told_.axes.size(); ++i)
    told_.axes[i] = std::abs(state.axes[i]) <= 1.0 ? state.axes[i] : 0.0;
}

safety::Wrench HapticLoop::exerted(const Eigen::Quaterniond& turn,
                                   const safety::Wrench& wrench) const noexcept {
  if (motors_ == 0) return wrench;
  const auto along = [&](const Eigen::Vector3d& whole, std::uint32_t axes) -> Eigen::Vector3d {
    if ((axes & 7U) == 7U) return whole;
    Eigen::Vector3d part = turn.conjugate() * whole;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      if ((axes >> axis & 1U) == 0) part[axis] = 0.0;
    return turn * part;
  };
  return {along(wrench.force_N, motors_), along(wrench.torque_N_m, motors_ >> 3U)};
}

void HapticLoop::begin_anew() noexcept {
  cut();
  held_ = {};
  reading_check_ = safety::DeviceReadingCheck(safety::reading_bounds(device_.descriptor()));
  velocity_ = {};
  angular_velocity_ = {};
  placement_ = {};
  has_pose_ = has_orientation_ = false;
}

TickEnd HapticLoop::sense(const publication::SceneView& scene, std::uint64_t now_ns) noexcept {
  const realtime::FlushDenormals flush;
  elapsed_s_ = to_s(++tick_ == 1 ? period_ns_ : now_ns - tick_ns_);
  if (tick_ == 1) start_ns_ = now_ns;
  tick_ns_ = now_ns;
  flags_ = 0;
  stillgrid_device_state state{};
  device_code_ = device_.read(now_ns, state);
  if (device_code_ == STILLGRID_DEVICE_END) return TickEnd::kDeviceEnd;
  if (device_code_ != STILLGRID_DEVICE_OK) return TickEnd::kDeviceFault;

  motion_ = {};
  const std::optional<safety::DeviceReading> reading = reading_check_.check(state, now_ns);
  believed_ = reading.has_value();
  flags_ |= reading_check_.reason() | safety::status_flags(state);
  note_device(state);
  if (reading) {
    place(scene.scene().device, *reading);
    buttons_ = reading->buttons;
  }
  if (!has_pose_) return TickEnd::kGoOn;  // nothing to show the simulation yet

  const Eigen::Quaterniond& q = pose_.orientation;
  tool_.publish({.time_ns = now_ns,
                 .tick = tick_,
                 .path_number = now_ns / proto::kPathTick_ns,
                 .position_m = array(pose_.position_m),
                 .orientation_xyzw = {q.x(), q.y(), q.z(), q.w()},
                 .velocity_m_s = array(pose_.velocity_m_s),
                 .force_N = array(held_.force_N),
                 .buttons = buttons_,
                 .before = figures_,
                 .device = told_});
  return TickEnd::kGoOn;
}

/// Books what was rendered, in the scene's lengths.
void HapticLoop::account(const publication::SceneView& scene, std::uint64_t now_ns) noexcept {
  const Eigen::Vector3d moved_m = (is_held_ ? 0.0 : scale_) * motion_.moved_m;
  interface_.note(now_ns, {moved_m, motion_.turned_rad},
                  {.epoch = scene.header().epoch,
                   .snapshot_id = rendered_.snapshot_id,
                   .can_move = rendered_.can_move,
                   .tool_time_ns = rendered_.tool_time_ns,
                   .tool_work_J = rendered_.tool_work_J,
                   .rendered = {rendered_.force.force_N, rendered_.force.torque_N_m},
                   .stiffness_N_per_m = rendered_.force.stiffness_N_per_m.trace(),
                   .static_J = rendered_.force.static_J,
                   .scale = scale_});
}

void HapticLoop::push_gripper(bool may_push, std::uint64_t now_ns) noexcept {
  if (device_.descriptor().max_gripper_force_N == 0.0) return;
  const bool is_told = (told_.told & STILLGRID_STATE_GRIPPER) != 0;
  told_.gripper_force_N = gripper_.apply(is_told ? std::optional(told_.gripper_m) : std::nullopt,
                                         may_push, elapsed_s_, stall_s_);
  if (device_code_ == STILLGRID_DEVICE_OK)
    device_code_ = device_.write_gripper(now_ns, told_.gripper_force_N);
}

rendering::Renderer& HapticLoop::renderer_of(const publication::SceneView& scene) noexcept {
  const bool is_held =
      hold_renderer_ != nullptr &&
      rendering::default_transition(scene, period_ns_) == display::Transition::kHold;
  return is_held ? *hold_renderer_ : *renderer_;
}

TickEnd HapticLoop::act(const publication::SceneView& scene, bool writer_alive,
                        std::uint64_t now_ns, recording::TickRow& row,
                        std::span<const publication::ToolView* const> other_tools,
                        rendering::LocalCopy* local) noexcept {
  const realtime::FlushDenormals flush;
  rendered_ = has_pose_ ? renderer_of(scene).render(scene, pose_, now_ns, other_tools, local)
                        : rendering::RenderedTick{};
  if (rendered_.contended) flags_ |= safety::kFlagContended;
  if (rendered_.truncated) flags_ |= safety::kFlagTruncated;
  if (rendered_.force.is_crushing) flags_ |= safety::kFlagCrushed;
  if (rendered_.is_new) snapshot_ns_ = now_ns;
  account(scene, now_ns);
  const proto::SceneHeader& fixed = scene.scene();
  const Eigen::Quaterniond turn = quaternion(fixed.device.orientation_xyzw);
  const bool is_ready = (flags_ & safety::kDeviceStatusMask) == 0;
  held_before_N_ = held_.force_N;
  held_ = safety_.apply(
      {.rendered = exerted(turn, {rendered_.force.force_N, rendered_.force.torque_N_m / scale_}),
       .stiffness_N_per_m = scale_ * rendered_.force.stiffness_N_per_m,
       .snapshot = {.exists = rendered_.snapshot_id != 0 && !is_released_ && !is_held_,
                    // A stamp of the future would never age.
                    .snapshot_age_s =
                        std::max(rendered_.snapshot_age_s, to_s(now_ns - snapshot_ns_)),
                    .period_s = to_s(scene.header().period_ns),
                    .writer_alive = writer_alive,
                    .goes_on = rendered_.is_local},
       .device_believed = believed_,
       .device_ready = is_ready,
       .device_m = device_m_,
       .velocity_m_s = pose_.velocity_m_s / scale_,
       .motion = motion_,
       .given_by_scenes_J = interface_.given_by_scenes_J(),
       .elapsed_s = elapsed_s_,
       .since_command_s = tick_ == 1 ? elapsed_s_ : to_s(time_at(now_ns) - commanded_ns_)},
      flags_);
  held_ = exerted(turn, held_);
  device_code_ =
      device_.write(now_ns, turn.conjugate() * held_.force_N, turn.conjugate() * held_.torque_N_m);
  commanded_ns_ = time_at(now_ns);
  push_gripper(is_ready && believed_ && !is_released_, now_ns);

  row = {.time_s = to_s(now_ns - start_ns_),
         .position_m = pose_.position_m,
         .velocity_m_s = pose_.velocity_m_s,
         .force_N = held_.force_N,
         .rendered_N = rendered_.force.force_N,
         .snapshot_id = rendered_.snapshot_id,
         .alpha = rendered_.weights.alpha,
         .contacts = rendered_.force.contacts,
         .age_s = rendered_.age_s,
         .tick_ns = 0,
         .flags = flags_,
         .torque_N_m = held_.torque_N_m,
         .orientation = pose_.orientation,
         .clock_ns = now_ns};
  figures_ = {.torque_N_m = array(held_.torque_N_m),
              .contacts = static_cast<std::uint32_t>(rendered_.force.contacts),
              .flags = flags_,
              .work_ns = 0,
              .wake_up_latency_ns = 0,
              .missed_ticks = figures_.missed_ticks,
              .displayed = rendering::displayed_snapshot(rendered_, scene.header().epoch)};
  return device_code_ == STILLGRID_DEVICE_OK ? TickEnd::kGoOn : TickEnd::kDeviceFault;
}

void HapticLoop::note_times(std::uint64_t work_ns, std::uint64_t wake_up_latency_ns,
                            std::uint64_t missed_ticks) noexcept {
  figures_.work_ns = work_ns;
  figures_.wake_up_latency_ns = wake_up_latency_ns;
  figures_.missed_ticks = missed_ticks;
}

void HapticLoop::count(const recording::TickRow& row, HapticReport& report) noexcept {
  count_tick(report, row, rendered_, held_before_N_, motion_.moved_m, elapsed_s_);
  report.energy = safety_.energy();
  report.interface = interface_.energy();
  if (temperature_C_)
    report.temperature_max_C =
        std::max(*temperature_C_, report.temperature_max_C.value_or(*temperature_C_));
  if (rendered_.is_new) ++report.snapshots;
}

}  // namespace stillgrid::haptic_server
