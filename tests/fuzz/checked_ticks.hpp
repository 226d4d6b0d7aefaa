#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "haptic_server/safety/safety_chain.hpp"
#include "tests/fuzz/fuzz_input.hpp"
#include "tests/laboratory/rivals/rivals.hpp"

namespace stillgrid::fuzz {

/// What the haptic loop does with a scene's segment, tick after tick, for two transitions and each
/// model, and the laws of it that no segment may break: the force commanded to the device is finite
/// and within its limit and changes no faster than it may, the work is bounded, no query leads out
/// of the grid.
class CheckedTicks {
 public:
  CheckedTicks();

  /// One tick; pose, clock and freshness come from the input.
  void tick(const publication::SceneView& scene, FuzzInput& input);

 private:
  void render(const publication::SceneView& scene, const rendering::ToolPose& pose,
              FuzzInput& input);

  struct Rendering {
    std::unique_ptr<rendering::Renderer> renderer;
    safety::SafetyChain safety;
  };
  std::vector<Rendering> renderings_;
  Eigen::Vector3d slewed_N_ = Eigen::Vector3d::Zero();  // the second chain's last force
  std::uint64_t now_ns_ = 90'000'000;  // when the valid segment's last snapshot was published

  static constexpr double kMaxForce_N = 3.3, kMaxSlew_N_per_ms = 0.5, kLever_m = 0.1;
  static constexpr std::size_t kSlewed = 1;
};

}  // namespace stillgrid::fuzz
