#include "sim_server/dynamics/forces/spring_jacobian.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::dynamics {
namespace {

/// Below it a spring has no direction, and so no force.
constexpr double kNoLength_m = 1e-12;

}  // namespace

Eigen::Vector3d spring_force_N(const bodies::Spring& spring, const bodies::Node& a,
                               const bodies::Node& b) {
  const Eigen::Vector3d line_m = b.position_m - a.position_m;
  const double length_m = line_m.norm();
  if (length_m < kNoLength_m) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d n = line_m / length_m;
  const double tension_N = spring.stiffness_N_per_m * (length_m - spring.rest_length_m) +
                           spring.damping_N_s_per_m * n.dot(b.velocity_m_s - a.velocity_m_s);
  return -tension_N * n;
}

void add_spring_jacobians(std::span<const bodies::Spring> springs,
                          std::span<const bodies::Node> nodes, JacobianKind kind, double stage_s,
                          std::vector<SpringJacobian>& jacobians) {
  for (const bodies::Spring& spring : springs) {
    const bodies::Node& a = nodes[static_cast<std::size_t>(spring.a)];
    const bodies::Node& b = nodes[static_cast<std::size_t>(spring.b)];
    if (a.unknown == bodies::kNoUnknown && b.unknown == bodies::kNoUnknown) continue;
    const Eigen::Vector3d line_m = b.position_m - a.position_m;
    const double length_m = line_m.norm();
    if (length_m < kNoLength_m) continue;
    const Eigen::Vector3d n = line_m / length_m;
    const Eigen::Vector3d velocity_m_s = b.velocity_m_s - a.velocity_m_s;
    const double lengthening_m_s = n.dot(velocity_m_s);
    const double tension_N = spring.stiffness_N_per_m * (length_m - spring.rest_length_m) +
                             spring.damping_N_s_per_m * lengthening_m_s;
    const double pull_N = kind == JacobianKind::kDefinite ? std::max(tension_N, 0.0) : tension_N;
    const double sideways = stage_s * stage_s * pull_N / length_m;
    const double along =
        stage_s * (stage_s * spring.stiffness_N_per_m + spring.damping_N_s_per_m) - sideways;
    SpringJacobian& own =
        jacobians.emplace_back(SpringJacobian{a.unknown, b.unknown, n, along * n, sideways});
    // The damper's direction turns with the spring.
    if (kind == JacobianKind::kExact)
      own.by += stage_s * stage_s * spring.damping_N_s_per_m / length_m *
                (velocity_m_s - lengthening_m_s * n);
  }
}

void add_spring_blocks(std::span<const bodies::Spring> springs, std::span<const bodies::Node> nodes,
                       JacobianKind kind, double stage_s, std::size_t& link,
                       BlockTriangle& triangle) {
  const bool is_definite = kind == JacobianKind::kDefinite;
  for (const bodies::Spring& spring : springs) {
    const bodies::Node& a = nodes[static_cast<std::size_t>(spring.a)];
    const bodies::Node& b = nodes[static_cast<std::size_t>(spring.b)];
    const bool a_moves = a.unknown != bodies::kNoUnknown, b_moves = b.unknown != bodies::kNoUnknown;
    if (!a_moves && !b_moves) continue;
    const std::size_t own = link;
    if (a_moves && b_moves) ++link;
    const Eigen::Vector3d line_m = b.position_m - a.position_m;
    const double length2_m2 = line_m.squaredNorm();
    if (length2_m2 < kNoLength_m * kNoLength_m) continue;
    const double length_m = std::sqrt(length2_m2);
    const double rate_m2_s = line_m.dot(b.velocity_m_s - a.velocity_m_s);
    double pull_N_per_m = (spring.stiffness_N_per_m * (length_m - spring.rest_length_m) +
                           spring.damping_N_s_per_m * rate_m2_s / length_m) /
                          length_m;
    if (is_definite) pull_N_per_m = std::max(pull_N_per_m, 0.0);
    const double sideways = stage_s * stage_s * pull_N_per_m;
    const double along =
        (stage_s * (stage_s * spring.stiffness_N_per_m + spring.damping_N_s_per_m) - sideways) /
        length2_m2;
    Eigen::Matrix3d block = (along * line_m) * line_m.transpose();
    block.diagonal().array() += sideways;
    if (a_moves) triangle.diagonal(a.unknown / 3) += block;
    if (b_moves) triangle.diagonal(b.unknown / 3) += block;
    if (a_moves && b_moves) triangle.below(own) -= block;
  }
}

void multiply_add(std::span<const SpringJacobian> jacobians, const Eigen::VectorXd& x,
                  Eigen::VectorXd& y) {
  for (const SpringJacobian& spring : jacobians) {
    Eigen::Vector3d change = Eigen::Vector3d::Zero();
    if (spring.b != bodies::kNoUnknown) change += x.segment<3>(spring.b);
    if (spring.a != bodies::kNoUnknown) change -= x.segment<3>(spring.a);
    const Eigen::Vector3d push = spring.by.dot(change) * spring.along + spring.sideways * change;
    if (spring.b != bodies::kNoUnknown) y.segment<3>(spring.b) += push;
    if (spring.a != bodies::kNoUnknown) y.segment<3>(spring.a) -= push;
  }
}

}  // namespace stillgrid::dynamics
