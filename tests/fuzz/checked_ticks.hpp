#pragma once

#include <cstdint>

#include "haptic_server/rendering/still_image.hpp"
#include "haptic_server/safety/force_guard.hpp"
#include "tests/fuzz/fuzz_input.hpp"

namespace stillgrid {

/// What the haptic loop does with a scene's segment, tick after tick, for each transition, and the
/// laws of it that no segment may break: the force told to the device is finite and within its
/// limit and changes no faster than it may, the work is bounded, no query leads out of the grid.
class CheckedTicks {
 public:
  CheckedTicks();

  /// One tick; pose, clock and freshness come from the input.
  void tick(const SceneView& scene, FuzzInput& input);

 private:
  void render(const SceneView& scene, const ToolPose& pose, FuzzInput& input);

  StillImageRenderer renderers_[2]{StillImageRenderer(Transition::kHold),
                                   StillImageRenderer(Transition::kLinear)};
  ForceGuard guards_[2]{ForceGuard({kMaxForce_N, {}}),
                        ForceGuard({kMaxForce_N, kMaxSlew_N_per_ms})};
  Eigen::Vector3d slewed_N_ = Eigen::Vector3d::Zero();  // the second guard's last force
  std::uint64_t now_ns_ = 90'000'000;  // when the valid segment's last image was published

  static constexpr double kMaxForce_N = 3.3, kMaxSlew_N_per_ms = 0.5, kLever_m = 0.1;
  static constexpr std::size_t kSlewed = 1;
  static constexpr double kFade_s = 0.1;
  static constexpr double kTick_s[2] = {kFade_s, 1e-3};  // the first is past the fade at once
  static constexpr double kMostChange_N =
      kMaxSlew_N_per_ms * kTick_s[kSlewed] * 1e3 + kMaxForce_N * kTick_s[kSlewed] / kFade_s;
};

}  // namespace stillgrid
