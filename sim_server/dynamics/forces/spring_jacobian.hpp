#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/solvers/block_triangle.hpp"
#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

namespace stillgrid::dynamics {

/// How a spring resists over an implicit stage of s: d(momentum - s force) / du on its node b by
/// that node's velocity unknowns is along * by^T + sideways * I; by node a's the negative of it.
struct SpringJacobian {
  int a = bodies::kNoUnknown, b = bodies::kNoUnknown;  // first unknowns of its nodes
  Eigen::Vector3d along, by;
  double sideways = 0.0;

  [[nodiscard]] Eigen::Matrix3d block() const {
    Eigen::Matrix3d block = along * by.transpose();
    block.diagonal().array() += sideways;
    return block;
  }
};

/// Force of a spring on its node b.
[[nodiscard]] Eigen::Vector3d spring_force_N(const bodies::Spring& spring, const bodies::Node& a,
                                             const bodies::Node& b);

/// Appends the Jacobians of springs that move anything, with the nodes where they are given.
void add_spring_jacobians(std::span<const bodies::Spring> springs,
                          std::span<const bodies::Node> nodes, JacobianKind kind, double stage_s,
                          std::vector<SpringJacobian>& jacobians);

/// Adds the same to blocks, of a symmetric kind: link is that of the first spring of these between
/// two nodes that move, and then the next one's. Pre: as many links lead on in the springs' order.
void add_spring_blocks(std::span<const bodies::Spring> springs, std::span<const bodies::Node> nodes,
                       JacobianKind kind, double stage_s, std::size_t& link,
                       BlockTriangle& triangle);

/// y += Jacobian x.
void multiply_add(std::span<const SpringJacobian> jacobians, const Eigen::VectorXd& x,
                  Eigen::VectorXd& y);

}  // namespace stillgrid::dynamics
