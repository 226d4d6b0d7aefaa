#include "sim_server/dynamics/forces/spring_jacobian.hpp"

#include <algorithm>

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
