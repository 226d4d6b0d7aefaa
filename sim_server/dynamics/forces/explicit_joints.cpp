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

/// How long a joint becomes at most within a time.
double longest_m(const bodies::World& world, const bodies::Joint& joint, double within_s) {
  const auto motion = [&](const bodies::JointEnd& end) {
    return bodies::end_motion(end, world.nodes, world.rigid_bodies);
  };
  const bodies::JointPull pull = bodies::joint_pull(joint, motion(joint.a), motion(joint.b));
  return pull.line_m.norm() + within_s * pull.velocity_m_s.norm();
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

JointSpectrum::JointSpectrum(const bodies::World& world)
    : carried_(world.nodes.size() + world.rigid_bodies.size() + 1) {
  for (const bodies::Joint& joint : world.joints)
    ends_.push_back({held_end(world, joint.a), held_end(world, joint.b)});
}

JointSpectrum::HeldEnd JointSpectrum::held_end(const bodies::World& world,
                                               const bodies::JointEnd& end) const {
  if (end.node >= 0) {
    const auto index = static_cast<std::size_t>(end.node);
    const bodies::Node& node = world.nodes[index];
    return {.thing = index, .by_mass_per_kg = node.pinned ? 0.0 : 1.0 / node.mass_kg};
  }
  if (end.rigid < 0) return {.thing = carried_.size() - 1};
  const auto index = static_cast<std::size_t>(end.rigid);
  const bodies::RigidBody& body = world.rigid_bodies[index];
  HeldEnd held{.thing = world.nodes.size() + index};
  if (!body.free) return held;
  const Eigen::Matrix3d arm = bodies::cross_matrix(end.point_m);
  const Eigen::Matrix3d turns =
      arm * body.inertia_kg_m2.cwiseInverse().asDiagonal() * arm.transpose();
  held.by_mass_per_kg = 1.0 / body.mass_kg;
  held.by_arm_per_kg = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(turns, Eigen::EigenvaluesOnly)
                           .eigenvalues()
                           .maxCoeff();
  held.arm_m = end.point_m.norm();
  held.inertia_kg_m2 = body.inertia_kg_m2.minCoeff();
  return held;
}

/// By Gershgorin's circles: of joints i and k that hold one thing, by their values c, the block is
/// at most sqrt(c_i c_k) (1/m + sqrt(t_i t_k)), t being what turning gives.
double JointSpectrum::largest_rate(std::span<const Row> rows) {
  const auto turning_per_kg = [](const HeldEnd& end, double more_m2) {
    return end.by_arm_per_kg + more_m2 / end.inertia_kg_m2;
  };
  std::ranges::fill(carried_, Carried{});
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t e = 0; e < 2; ++e) {
      Carried& own = carried_[ends_[i][e].thing];
      own.sum += std::sqrt(rows[i].value);
      own.turning += std::sqrt(rows[i].value * turning_per_kg(ends_[i][e], rows[i].more_m2[e]));
    }
  double largest = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double row = 0.0;
    for (std::size_t e = 0; e < 2; ++e) {
      const HeldEnd& end = ends_[i][e];
      const Carried& own = carried_[end.thing];
      row += own.sum * end.by_mass_per_kg +
             own.turning * std::sqrt(turning_per_kg(end, rows[i].more_m2[e]));
    }
    largest = std::max(largest, std::sqrt(rows[i].value) * row);
  }
  return largest;
}

SpringRates JointSpectrum::bound(const bodies::World& world, double within_s) {
  if (ends_.empty()) return {};
  springs_.clear();
  dampers_.clear();
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    const bodies::Joint& joint = world.joints[i];
    const double length_m = longest_m(world, joint, within_s);
    const double arm_a_m = ends_[i][0].arm_m, arm_b_m = ends_[i][1].arm_m;
    // What is long turns what it holds back into its line: k arm length, beside k arm^2.
    springs_.push_back({joint.stiffness_N_per_m, {arm_a_m * length_m, arm_b_m * length_m}});
    // It acts on b at the place of a, a length beyond the arm.
    dampers_.push_back({joint.damping_N_s_per_m, {0.0, (2.0 * arm_b_m + length_m) * length_m}});
  }
  return {largest_rate(springs_), largest_rate(dampers_)};
}

}  // namespace stillgrid::dynamics
