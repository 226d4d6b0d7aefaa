#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/recording/recorder.hpp"
#include "haptic_server/rendering/renderer.hpp"
#include "haptic_server/rendering/velocity_estimator.hpp"
#include "haptic_server/report.hpp"
#include "haptic_server/safety/energy_observer.hpp"
#include "haptic_server/safety/force_guard.hpp"
#include "haptic_server/safety/passivity_controller.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/tool_segment.hpp"

namespace stillgrid {

/// What a tick came to.
enum class TickEnd { kGoOn, kDeviceEnd, kDeviceFault };

/// One tick of the haptic loop, in its two halves: the device's pose out to the simulation, then
/// the force to the device. Between them lockstep waits for the simulation.
///
/// The safety chain: passivity control if there is one, then the guard; the energy account sees
/// what came out of it. Thread: the loop's. Realtime: allocates nothing, takes no lock, makes no
/// system call but the device's.
class HapticLoop {
 public:
  HapticLoop(Device& device, ToolWriter& tool, std::unique_ptr<Renderer> renderer,
             const GuardLimits& limits, std::uint64_t period_ns,
             std::optional<PassivityController> passivity_control = std::nullopt)
      : device_(device),
        tool_(tool),
        renderer_(std::move(renderer)),
        passivity_control_(std::move(passivity_control)),
        guard_(limits),
        period_ns_(period_ns) {}

  /// Reads the device at now_ns, places it in the scene and publishes the tool.
  [[nodiscard]] TickEnd sense(const SceneView& scene, std::uint64_t now_ns) noexcept;

  /// Renders the force, guards it, gives it to the device, and counts. row: of this tick, for a
  /// record; its tick_ns is the caller's to fill in before count().
  [[nodiscard]] TickEnd act(const SceneView& scene, bool writer_alive, std::uint64_t now_ns,
                            TickRow& row) noexcept;

  /// Adds the tick of the last act() to the report.
  void count(const TickRow& row, HapticReport& report) noexcept;

  /// Whether the next tick may be of another scene: only when no force is felt. Realtime: yes.
  [[nodiscard]] bool may_switch_scene() const noexcept { return guard_.is_silent(); }

  [[nodiscard]] std::int32_t device_code() const noexcept { return device_code_; }
  /// What the last act() rendered.
  [[nodiscard]] const RenderedTick& rendered() const noexcept { return rendered_; }

 private:
  Device& device_;
  ToolWriter& tool_;
  std::unique_ptr<Renderer> renderer_;
  std::optional<PassivityController> passivity_control_;
  ForceGuard guard_;
  VelocityEstimator velocity_;
  AngularVelocityEstimator angular_velocity_;
  std::uint64_t period_ns_;

  std::uint64_t tick_ = 0, start_ns_ = 0;
  std::int32_t device_code_ = 0;
  bool has_pose_ = false, has_orientation_ = false;
  ToolPose pose_;  // scene frame
  std::uint32_t flags_ = 0;
  Eigen::Vector3d device_m_ = Eigen::Vector3d::Zero();  // device frame
  DeviceMotion motion_;                                 // since the tick before, scene's axes
  Wrench held_;                                         // told to the device, scene's axes
  HandEnergy energy_;
  Eigen::Vector3d held_before_N_ = Eigen::Vector3d::Zero();
  RenderedTick rendered_;
};

}  // namespace stillgrid
