#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim_server/spheres/ball.hpp"

namespace stillgrid::spheres {

/// Finds balls by how far their surfaces are from a point, whatever their sizes: a tree of boxes
/// round halves of the balls.
class BallTree {
 public:
  /// Keeps a view of the balls. Pre: not empty, all finite.
  explicit BallTree(std::span<const Ball> balls);

  /// The least distance from a point to a ball's surface, m; negative within a ball.
  [[nodiscard]] double least_gap_m(const Eigen::Vector3d& point_m) const;

  /// The balls whose surface is no farther than search_radius_m, ascending.
  [[nodiscard]] std::vector<std::uint32_t> balls_within(const Eigen::Vector3d& point_m,
                                                        double search_radius_m) const;

 private:
  struct Node {
    Eigen::Vector3d low_m, high_m;  // of the centres
    double widest_m;                // of the radii
    std::uint32_t begin, end;       // in order_
    std::uint32_t right;            // the left half's node follows; 0: a leaf
  };
  void build(std::uint32_t begin, std::uint32_t end);
  [[nodiscard]] static double least_possible_m(const Node& node, const Eigen::Vector3d& point_m);
  [[nodiscard]] double gap_m(std::uint32_t ball, const Eigen::Vector3d& point_m) const;

  std::span<const Ball> balls_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace stillgrid::spheres
