#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "sim_server/bodies/world.hpp"

namespace stillgrid::dynamics {

/// Returns M^-1/2 K M^-1/2 of the springs, over the nodes that are not pinned. Compressed springs
/// do not soften it.
[[nodiscard]] inline Eigen::MatrixXd spring_matrix_per_s2(const bodies::World& world) {
  std::vector<Eigen::Index> first;  // index in the matrix by node; negative: pinned
  Eigen::Index count = 0;
  for (const bodies::Node& node : world.nodes) {
    first.push_back(node.pinned ? -1 : count);
    if (!node.pinned) count += 3;
  }
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
  for (const bodies::Spring& spring : world.springs) {
    const auto a = static_cast<std::size_t>(spring.a), b = static_cast<std::size_t>(spring.b);
    const Eigen::Vector3d line_m = world.nodes[b].position_m - world.nodes[a].position_m;
    const Eigen::Vector3d n = line_m.normalized();
    const double k = spring.stiffness_N_per_m;
    const double across = std::max(0.0, k * (1.0 - spring.rest_length_m / line_m.norm()));
    const Eigen::Matrix3d block =
        (k - across) * n * n.transpose() + across * Eigen::Matrix3d::Identity();
    const auto add = [&](std::size_t row, std::size_t column, double sign) {
      if (first[row] < 0 || first[column] < 0) return;
      matrix.block<3, 3>(first[row], first[column]) +=
          sign / std::sqrt(world.nodes[row].mass_kg * world.nodes[column].mass_kg) * block;
    };
    add(a, a, 1.0);
    add(b, b, 1.0);
    add(a, b, -1.0);
    add(b, a, -1.0);
  }
  return matrix;
}

}  // namespace stillgrid::dynamics
