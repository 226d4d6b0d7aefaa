#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "shared/collision/voxel_grid.hpp"

namespace stillgrid::performance {

/// Another's way to all pairs of balls that overlap: its broad phase, kept from step to step, and a
/// test of distance on each pair of boxes that it reports.
class DetectionPeer {
 public:
  virtual ~DetectionPeer() = default;
  /// Moves the balls there and returns how many pairs overlap.
  [[nodiscard]] virtual std::size_t find(std::span<const collision::SweptBound> balls) = 0;
};

/// Bullet's 32-bit sweep along three axes. half_edge_m: the world about the origin.
[[nodiscard]] std::unique_ptr<DetectionPeer> bullet_axis_sweep(
    std::span<const collision::SweptBound> balls, float half_edge_m);

/// Bullet's dynamic tree of boxes, against itself. margin_m: boxes are that much wider, and stay in
/// place while they hold their balls.
[[nodiscard]] std::unique_ptr<DetectionPeer> bullet_tree(
    std::span<const collision::SweptBound> balls, float margin_m);

/// FCL's dynamic tree of boxes.
[[nodiscard]] std::unique_ptr<DetectionPeer> fcl_tree(std::span<const collision::SweptBound> balls);

}  // namespace stillgrid::performance
