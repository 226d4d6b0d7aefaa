#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "shared/rendering/mode_response.hpp"
#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Renders the force of a transition whose spheres give way: the newest snapshot led on by the
/// simulation's own next step, for the hand where it is now (docs/algorithms/predict.md).
///
/// Each tick finds the forces at the contacts to which the spheres give way so that they exert
/// them. What a snapshot shows otherwise than was displayed is ramped out, as a shift of each
/// touched body over half a period, and the little that this leaves of the force within 3 ms.
/// Thread: the haptic loop's only.
class CompliantRenderer final : public Renderer {
 public:
  /// Pre: law_of(transition).gives_way.
  explicit CompliantRenderer(display::Transition transition = display::Transition::kPredict)
      : transition_(transition) {}

 private:
  void prepare(const TickScene& scene, bool is_other) noexcept override;
  void gather(const TickScene& scene, const proto::SnapshotHeader& latest,
              const collision::GridView& moving) noexcept override;
  void show(const TickScene& scene, const publication::SnapshotLook& look,
            RenderedTick& tick) noexcept override;

  /// A snapshot as it is displayed, and what it is ramped out with.
  struct Display {
    display::SnapshotWeights weights;
    ModeResponse response;
    std::uint64_t began_ns = 0;  // the first tick that displayed it
    BodyShifts shifts;           // when it came
    double shift_s = 0.0;        // over which they are ramped out
    // What of the force that was displayed when it came is not a share of its own.
    double force_share = 1.0;
    Eigen::Vector3d residual_N = Eigen::Vector3d::Zero();
    Eigen::Vector3d residual_torque_N_m = Eigen::Vector3d::Zero();
    double rest_s = 0.0;
  };
  [[nodiscard]] CompliantDisplay compliant_display(const Display& display,
                                                   std::uint64_t now_ns) const noexcept;
  [[nodiscard]] ToolForce solve(const TickScene& scene, bool is_switch, Display& display) noexcept;
  [[nodiscard]] static ToolForce with_rest(ToolForce force, const Display& display,
                                           std::uint64_t now_ns) noexcept;
  void begin_as(const ToolForce& displayed, const ToolForce& force,
                Display& display) const noexcept;
  void lead_on(const TickScene& scene) noexcept;
  [[nodiscard]] std::optional<display::ResponseMatrix> next_response(
      const TickScene& scene, const collision::GridView& moving,
      const TouchedSphere& sphere) const noexcept;
  [[nodiscard]] std::optional<Eigen::Vector3d> next_place_m(
      const TickScene& scene, const collision::GridView& moving, const TouchedSphere& sphere,
      const CompliantDisplay& by_push) const noexcept;
  void continue_from(const TickScene& scene, const collision::GridView& moving) noexcept;
  void shift_bodies(const TickScene& scene, const collision::GridView& moving) noexcept;
  void compare(const TickScene& scene, TouchedSphere sphere, const Eigen::Vector3d& led_m,
               const Eigen::Vector3d& now_m) noexcept;

  display::Transition transition_;
  Display shown_;              // of the last accepted snapshot
  Display next_;               // being gathered
  std::uint64_t tick_ns_ = 0;  // of the last tick
  TouchedSpheres buffers_[2];
  TouchedSpheres* touched_ = &buffers_[0];  // moving ones, of the last accepted read
  TouchedSpheres* fresh_ = &buffers_[1];    // being gathered
  TouchedSpheres static_;                   // of the static grid
  ToolSweep sweep_;
  std::span<const PlacedToolSphere> tool_;  // of this tick
  double radius_m_ = 0.0;                   // the largest of the tool's
  ResponseSolver solver_;
  double unsolved_N_ = 0.0;                            // of this tick's response
  Eigen::Vector3d error_N_ = Eigen::Vector3d::Zero();  // of the snapshot that is gathered
  std::optional<PredictionError> error_;
  Eigen::Vector3d led_bare_N_ = Eigen::Vector3d::Zero();  // without what is ramped out
  std::optional<ToolForce> led_on_;  // of what was displayed a tick ago; where it was asked for
};

}  // namespace stillgrid::rendering
