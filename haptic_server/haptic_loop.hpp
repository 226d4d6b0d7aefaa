#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/recording/recorder.hpp"
#include "haptic_server/report.hpp"
#include "haptic_server/safety/device_reading.hpp"
#include "haptic_server/safety/interface_account.hpp"
#include "haptic_server/safety/safety_chain.hpp"
#include "haptic_server/tool_placement.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/tool_segment.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/velocity_estimator.hpp"

namespace stillgrid::haptic_server {

/// The result of a tick.
enum class TickEnd { kGoOn, kDeviceEnd, kDeviceFault };

/// One tick of the haptic loop, in its two halves: the device's pose out to the simulation, then
/// the force to the device. Between them lockstep waits for the simulation.
///
/// The device gets the force that passes the safety chain. Thread: the loop's. Realtime:
/// allocates nothing, takes no lock, makes no system call but the device's.
class HapticLoop {
 public:
  /// The clock of the ticks, by which a tick knows how late in it the device is told; in virtual
  /// time there is none: a tick takes no time.
  using Clock = std::uint64_t (*)();

  /// held: renders in place of `renderer` where a scene has no model, and its snapshots last for
  /// one tick or less; or none.
  HapticLoop(device::Device& device, publication::ToolWriter& tool,
             std::unique_ptr<rendering::Renderer> renderer, const safety::SafetyLimits& limits,
             std::uint64_t period_ns, Clock clock = nullptr,
             std::unique_ptr<rendering::Renderer> held = nullptr)
      : device_(device),
        tool_(tool),
        renderer_(std::move(renderer)),
        hold_renderer_(std::move(held)),
        reading_check_(safety::reading_bounds(device.descriptor())),
        safety_(with_period(limits, period_ns)),
        gripper_(limits.gripper),
        stall_s_(with_period(limits, period_ns).stall_s),
        motors_(device.descriptor().dof_actuated),
        interface_(1e-9 * static_cast<double>(period_ns)),
        period_ns_(period_ns),
        clock_(clock) {}

  /// Makes the tool obey orders from the next tick on. Pre: they outlive the loop.
  void obey(const ToolOrders& orders) noexcept { orders_ = &orders; }

  /// Reads the device at now_ns, places it in the scene and publishes the tool, and with it
  /// the figures of the tick before. The tool's path takes the first tick of a millisecond.
  [[nodiscard]] TickEnd sense(const publication::SceneView& scene, std::uint64_t now_ns) noexcept;

  /// Renders the force, guards it, gives it to the device, and counts. row: of this tick, for a
  /// record; its tick_ns is the caller's to fill in before count(). other_tools, local: as
  /// Renderer::render().
  [[nodiscard]] TickEnd act(const publication::SceneView& scene, bool writer_alive,
                            std::uint64_t now_ns, recording::TickRow& row,
                            std::span<const publication::ToolView* const> other_tools = {},
                            rendering::LocalCopy* local = nullptr) noexcept;

  /// Tells readers of the tool what the tick of the last act() took. In lockstep nothing is told.
  void note_times(std::uint64_t work_ns, std::uint64_t wake_up_latency_ns,
                  std::uint64_t missed_ticks) noexcept;

  /// Adds the tick of the last act() to the report.
  void count(const recording::TickRow& row, HapticReport& report) noexcept;

  /// Whether the next tick may be of another scene: only when no force is felt. Realtime: yes.
  [[nodiscard]] bool may_switch_scene() const noexcept { return safety_.is_silent(); }

  /// For a device that was stopped from outside and is active again: no force, then a ramp.
  void cut() noexcept { safety_.cut(); }

  /// Calls cut() for a device that was closed meanwhile. It may have been moved, and stamps and
  /// counts samples anew.
  void begin_anew() noexcept;

  /// Lets go of the hand: from now on the force fades, as from a dead simulation. Whether none is
  /// felt any more. Realtime: yes.
  [[nodiscard]] bool release() noexcept {
    is_released_ = true;
    return held_.force_N.isZero(0.0) && held_.torque_N_m.isZero(0.0) &&
           told_.gripper_force_N == 0.0;
  }

  [[nodiscard]] std::int32_t device_code() const noexcept { return device_code_; }
  /// The forces that the last act() rendered.
  [[nodiscard]] const rendering::RenderedTick& rendered() const noexcept { return rendered_; }

 private:
  /// Three periods without a tick are no stall, however long a period is.
  [[nodiscard]] static safety::SafetyLimits with_period(safety::SafetyLimits limits,
                                                        std::uint64_t period_ns) noexcept {
    limits.period_s = 1e-9 * static_cast<double>(period_ns);
    limits.stall_s = std::max(limits.stall_s, 3.0 * limits.period_s);
    return limits;
  }
  [[nodiscard]] std::uint64_t time_at(std::uint64_t now_ns) const {
    return clock_ == nullptr ? now_ns : std::max(now_ns, clock_());
  }
  void place(const proto::DeviceFrame& frame, const safety::DeviceReading& reading) noexcept;
  void push_gripper(bool may_push, std::uint64_t now_ns) noexcept;
  void note_device(const stillgrid_device_state& state) noexcept;
  /// What the device's motors can exert of it; scene's axes.
  [[nodiscard]] safety::Wrench exerted(const Eigen::Quaterniond& turn,
                                       const safety::Wrench& wrench) const noexcept;
  void account(const publication::SceneView& scene, std::uint64_t now_ns) noexcept;

  device::Device& device_;
  publication::ToolWriter& tool_;
  std::unique_ptr<rendering::Renderer> renderer_;
  std::unique_ptr<rendering::Renderer> hold_renderer_;  // none: renderer_ for all scenes
  [[nodiscard]] rendering::Renderer& renderer_of(const publication::SceneView& scene) noexcept;
  safety::DeviceReadingCheck reading_check_;
  safety::SafetyChain safety_;
  safety::GripperSpring gripper_;
  double stall_s_;
  std::uint32_t motors_;  // STILLGRID_DOF_..., 0: not told
  safety::InterfaceAccount interface_;
  rendering::VelocityEstimator velocity_;
  rendering::AngularVelocityEstimator angular_velocity_;
  std::uint64_t period_ns_;
  Clock clock_;

  std::uint64_t tick_ = 0, start_ns_ = 0, tick_ns_ = 0, commanded_ns_ = 0;
  double elapsed_s_ = 0.0;  // since the tick before
  std::int32_t device_code_ = 0;
  bool has_pose_ = false, has_orientation_ = false, believed_ = false;
  bool is_released_ = false;
  const ToolOrders* orders_ = nullptr;
  ToolPlacement placement_;
  double scale_ = 1.0;        // scene's lengths to the device's
  bool is_held_ = false;      // a force that no motion changes would give energy
  rendering::ToolPose pose_;  // scene frame
  std::uint32_t flags_ = 0, buttons_ = 0;
  std::optional<double> temperature_C_;                 // as the device last told
  Eigen::Vector3d device_m_ = Eigen::Vector3d::Zero();  // device frame
  safety::DeviceMotion motion_;                         // since the tick before, scene's axes
  safety::Wrench held_;                                 // told to the device, scene's axes
  Eigen::Vector3d held_before_N_ = Eigen::Vector3d::Zero();
  rendering::RenderedTick rendered_;
  proto::TickFigures figures_{};   // of the last act()
  proto::DeviceFigures told_{};    // by the device in the last sense(), and to its gripper
  std::uint64_t snapshot_ns_ = 0;  // when the snapshot shown was first seen
};

}  // namespace stillgrid::haptic_server
