#include "sim_server/dynamics/forces/explicit_joints.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "sim_server/bodies/joints.hpp"
#include "sim_server/bodies/rotation.hpp"

namespace stillgrid::dynamics {
namespace {

bodies::EndMotion motion_of(const bodies::JointEnd& end, const ExplicitState& state) {
  if (end.node >= 0) {
    const auto node = static_cast<std::size_t>(end.node);
    return {.centre_m = state.position_m[node].map(),
            .velocity_m_s = state.velocity_m_s[node].map()};
  }
  if (end.rigid < 0) return {.centre_m = end.point_m};
  const RigidState& body = state.rigid[static_cast<std::size_t>(end.rigid)];
  return {body.position_m, body.rotation * end.point_m, body.velocity_m_s, body.spin_rad_s};
}

bool moves(const bodies::JointEnd& end, const ExplicitState& state) {
  if (end.node >= 0) return state.inverse_mass_per_kg[static_cast<std::size_t>(end.node)] > 0.0;
  return end.rigid >= 0 && state.rigid[static_cast<std::size_t>(end.rigid)].free;
}

/// Adds a force at an end that is a lever away from its centre.
void push(const bodies::JointEnd& end, const Eigen::Vector3d& lever_m,
          const Eigen::Vector3d& force_N, ExplicitState& state) {
  if (!moves(end, state)) return;
  if (end.node >= 0) {
    state.force_N[static_cast<std::size_t>(end.node)].map() += force_N;
    return;
  }
  RigidState& body = state.rigid[static_cast<std::size_t>(end.rigid)];
  body.force_N += force_N;
  body.torque_N_m += lever_m.cross(force_N);
}

/// How easily an end gives way that moves, by its thing's mass and by its turning: 1/kg.
struct Compliance {
  double by_mass_per_kg = 0.0, by_turning_per_kg = 0.0;
};
/// By a lever that grows on top of the arm: what is at most added to its square is `more_m2`.
Compliance compliance_of(const bodies::World& world, const bodies::JointEnd& end, double more_m2) {
  if (end.node >= 0) {
    const bodies::Node& node = world.nodes[static_cast<std::size_t>(end.node)];
    return {node.pinned ? 0.0 : 1.0 / node.mass_kg, 0.0};
  }
  if (end.rigid < 0) return {};
  const bodies::RigidBody& body = world.rigid_bodies[static_cast<std::size_t>(end.rigid)];
  if (!body.free) return {};
  const Eigen::Matrix3d arm = bodies::cross_matrix(end.point_m);
  const Eigen::Matrix3d turns =
      arm * body.inertia_kg_m2.cwiseInverse().asDiagonal() * arm.transpose();
  const double by_arm_per_kg =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(turns, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .maxCoeff();
  return {1.0 / body.mass_kg, by_arm_per_kg + more_m2 / body.inertia_kg_m2.minCoeff()};
}

/// What one of a joint's two forces does to what it holds: its own value c, and what the joint's
/// length adds to the square of an arm at each end.
struct Row {
  double value;
  double more_a_m2, more_b_m2;
};

/// How long a joint becomes at most within a time.
double longest_m(const bodies::World& world, const bodies::Joint& joint, double within_s) {
  const auto motion = [&](const bodies::JointEnd& end) {
    return bodies::end_motion(end, world.nodes, world.rigid_bodies);
  };
  const bodies::JointPull pull = bodies::joint_pull(joint, motion(joint.a), motion(joint.b));
  return pull.line_m.norm() + within_s * pull.velocity_m_s.norm();
}

/// A spring that is long turns what it holds back into its line: k arm length, beside k arm^2.
Row spring_row(const bodies::Joint& joint, double length_m) {
  return {joint.stiffness_N_per_m, joint.a.point_m.norm() * length_m,
          joint.b.point_m.norm() * length_m};
}

/// A damper acts on b at the place of a, a length beyond its arm.
Row damper_row(const bodies::Joint& joint, double length_m) {
  return {joint.damping_N_s_per_m, 0.0, (2.0 * joint.b.point_m.norm() + length_m) * length_m};
}

/// By Gershgorin's circles: of joints i and k that hold one thing, by their values c, the block is
/// at most sqrt(c_i c_k) (1/m + sqrt(t_i t_k)), t being what turning gives.
double largest_rate(const bodies::World& world, std::span<const Row> rows) {
  struct Carried {
    double sum = 0.0, turning = 0.0;  // of sqrt(c), and of sqrt(c t)
  };
  std::vector<Carried> nodes(world.nodes.size()), rigid_bodies(world.rigid_bodies.size());
  const auto visit_end = [&](const bodies::JointEnd& end, double more_m2, const auto& visit) {
    if (end.node >= 0 || end.rigid >= 0)
      visit(end.node >= 0 ? nodes[static_cast<std::size_t>(end.node)]
                          : rigid_bodies[static_cast<std::size_t>(end.rigid)],
            compliance_of(world, end, more_m2));
  };
  const auto for_each_end = [&](std::size_t i, const auto& visit) {
    visit_end(world.joints[i].a, rows[i].more_a_m2, visit);
    visit_end(world.joints[i].b, rows[i].more_b_m2, visit);
  };
  for (std::size_t i = 0; i < rows.size(); ++i)
    for_each_end(i, [&](Carried& own, const Compliance& gives) {
      own.sum += std::sqrt(rows[i].value);
      own.turning += std::sqrt(rows[i].value * gives.by_turning_per_kg);
    });
  double largest = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double row = 0.0;
    for_each_end(i, [&](const Carried& own, const Compliance& gives) {
      row += own.sum * gives.by_mass_per_kg + own.turning * std::sqrt(gives.by_turning_per_kg);
    });
    largest = std::max(largest, std::sqrt(rows[i].value) * row);
  }
  return largest;
}

}  // namespace

JointPower pull_joints(const bodies::World& world, ExplicitState& state) {
  JointPower power;
  for (const bodies::Joint& joint : world.joints) {
    if (!moves(joint.a, state) && !moves(joint.b, state)) continue;
    const bodies::EndMotion a = motion_of(joint.a, state), b = motion_of(joint.b, state);
    const bodies::JointPull pull = bodies::joint_pull(joint, a, b);
    const Eigen::Vector3d force_N = pull.spring_N + pull.damper_N;
    push(joint.a, a.arm_m, force_N, state);
    push(joint.b, pull.lever_b_m, -force_N, state);
    power.damping_W -= pull.damper_N.dot(pull.velocity_m_s);
    if (!moves(joint.a, state)) power.given_W -= force_N.dot(a.velocity_m_s);
    if (!moves(joint.b, state)) power.given_W += force_N.dot(b.velocity_m_s);
  }
  return power;
}

SpringRates joint_rates(const bodies::World& world, double within_s) {
  std::vector<Row> springs, dampers;
  for (const bodies::Joint& joint : world.joints) {
    const double length_m = longest_m(world, joint, within_s);
    springs.push_back(spring_row(joint, length_m));
    dampers.push_back(damper_row(joint, length_m));
  }
  return {largest_rate(world, springs), largest_rate(world, dampers)};
}

}  // namespace stillgrid::dynamics
