// What contacts ask of bodies and nodes, and what these make of it.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim_server/bodies/rotation.hpp"
#include "sim_server/dynamics/contacts/contact_movers.hpp"

namespace stillgrid::dynamics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What is no number is larger than all.
double larger(double most, double value) {
  return value <= most ? most : value;
}

/// A padded vector as what registers hold.
using Four = Eigen::Array4d;
auto four(PackedVector& vector) {
  return Eigen::Map<Four, Eigen::Aligned32>(&vector.x);
}
auto four(const PackedVector& vector) {
  return Eigen::Map<const Four, Eigen::Aligned32>(&vector.x);
}

std::size_t number(int i) {
  return static_cast<std::size_t>(i);
}

/// The inverse of [linear, coupled^T; coupled, turning], by blocks: closed forms of 3 x 3 cost a
/// tenth of a factorisation of 6 x 6.
void invert(Matrix6& matrix) {
  const Matrix3d coupled = matrix.bottomLeftCorner<3, 3>();
  const Matrix3d linear = matrix.topLeftCorner<3, 3>().inverse();
  const Matrix3d shared = coupled.lazyProduct(linear);
  const Matrix3d turn =
      (matrix.bottomRightCorner<3, 3>() - shared.lazyProduct(coupled.transpose())).inverse();
  const Matrix3d cross = -turn.lazyProduct(shared);
  matrix.bottomRightCorner<3, 3>() = turn;
  matrix.bottomLeftCorner<3, 3>() = cross;
  matrix.topRightCorner<3, 3>() = cross.transpose();
  matrix.topLeftCorner<3, 3>() = linear - shared.transpose().lazyProduct(cross);
}

}  // namespace

std::span<RigidMover> ContactMovers::rigid_of(const ContactIsland& island) {
  return std::span(rigid_movers_)
      .subspan(island.rigid.first, island.rigid.last - island.rigid.first);
}
std::span<NodeMover> ContactMovers::nodes_of(const ContactIsland& island) {
  return std::span(node_movers_)
      .subspan(island.nodes.first, island.nodes.last - island.nodes.first);
}

void ContactMovers::start(ExplicitState& state) {
  // At rest the velocities before all forces are the solution, to rounding.
  for (RigidMover& mover : rigid_movers_) {
    RigidState& body = state.rigid[number(mover.rigid)];
    mover.free << body.velocity_m_s, body.spin_rad_s;
    mover.inertia_kg_m2 = body.inverse_inertia_per_kg_m2.inverse();
    body.velocity_m_s = mover.start.head<3>();
    body.spin_rad_s = mover.start.tail<3>();
    mover.direction.setZero();
  }
  for (NodeMover& mover : node_movers_) {
    auto velocity_m_s = state.velocity_m_s[number(mover.node)].map();
    mover.free = velocity_m_s;
    velocity_m_s = mover.start;
    mover.direction.setZero();
  }
}

double ContactMovers::largest_m_s(const ContactIsland& island) const {
  double largest_m_s = 0.0;
  for (std::size_t i = island.rigid.first; i < island.rigid.last; ++i)
    largest_m_s = std::max(largest_m_s, rigid_movers_[i].free.head<3>().norm());
  for (std::size_t i = island.nodes.first; i < island.nodes.last; ++i)
    largest_m_s = std::max(largest_m_s, node_movers_[i].free.norm());
  return largest_m_s;
}

void ContactMovers::note_start(const ExplicitState& state) {
  for (RigidMover& mover : rigid_movers_) {
    const RigidState& body = state.rigid[number(mover.rigid)];
    mover.start << body.velocity_m_s, body.spin_rad_s;
    mover.arm_m = 0.0;
  }
  for (NodeMover& mover : node_movers_) mover.start = state.velocity_m_s[number(mover.node)].map();
  for (const ContactIsland& island : islands_) place_points(island, state);
}

void ContactMovers::reach(int point, const Vector3d& arm_m) {
  double& farthest_m = rigid_movers_[number(point) - 1].arm_m;
  if (arm_m.squaredNorm() > farthest_m * farthest_m) farthest_m = arm_m.norm();
}

void ContactMovers::place_points(const ContactIsland& island, const ExplicitState& state) {
  for (std::size_t i = island.rigid.first; i < island.rigid.last; ++i) {
    const RigidState& body = state.rigid[number(rigid_movers_[i].rigid)];
    velocities_[1 + i].linear.map() = body.velocity_m_s;
    velocities_[1 + i].angular.map() = body.spin_rad_s;
  }
  const std::size_t soft = 1 + rigid_movers_.size();
  for (std::size_t i = island.soft.first; i < island.soft.last; ++i) {
    const SoftPoint& point = soft_[i];
    Four sum_m_s = Four::Zero();
    for (std::size_t k = 0; k < number(point.node_count); ++k)
      sum_m_s += point.weights[k] * four(state.velocity_m_s[number(point.nodes[k])]);
    four(velocities_[soft + i].linear) = sum_m_s;
  }
}

std::span<ContactPoint> ContactMovers::clear_impulses(const ContactIsland& island) {
  std::fill(impulses_.begin() + static_cast<std::ptrdiff_t>(1 + island.rigid.first),
            impulses_.begin() + static_cast<std::ptrdiff_t>(1 + island.rigid.last), ContactPoint{});
  const auto soft = impulses_.begin() + static_cast<std::ptrdiff_t>(1 + rigid_movers_.size());
  std::fill(soft + static_cast<std::ptrdiff_t>(island.soft.first),
            soft + static_cast<std::ptrdiff_t>(island.soft.last), ContactPoint{});
  return impulses_;
}

void ContactMovers::gather_impulses(const ContactIsland& island) {
  for (std::size_t i = island.rigid.first; i < island.rigid.last; ++i)
    rigid_movers_[i].impulse << impulses_[1 + i].linear.map(), impulses_[1 + i].angular.map();
  for (std::size_t i = island.nodes.first; i < island.nodes.last; ++i) node_impulse_N_s_[i] = {};
  const std::size_t soft = 1 + rigid_movers_.size();
  for (std::size_t i = island.soft.first; i < island.soft.last; ++i) {
    const SoftPoint& point = soft_[i];
    const Four impulse_N_s = four(impulses_[soft + i].linear);
    for (std::size_t k = 0; k < number(point.node_count); ++k)
      four(node_impulse_N_s_[number(point.movers[k])]) += point.weights[k] * impulse_N_s;
  }
}

void ContactMovers::begin_responses(const ContactIsland& island, bool all) {
  const auto begin = [all](auto& mover) {
    mover.is_widened = all;
    if (all) mover.response.setZero();
  };
  std::ranges::for_each(rigid_of(island), begin);
  std::ranges::for_each(nodes_of(island), begin);
}

void ContactMovers::widen(int point) {
  if (point == 0) return;
  const auto begin = [](auto& mover) {
    if (!std::exchange(mover.is_widened, true)) mover.response.setZero();
  };
  const std::size_t place = number(point) - 1;
  if (place < rigid_movers_.size()) {
    begin(rigid_movers_[place]);
    return;
  }
  const SoftPoint& soft = soft_[place - rigid_movers_.size()];
  for (std::size_t i = 0; i < number(soft.node_count); ++i)
    if (number(soft.movers[i]) < node_movers_.size()) begin(node_movers_[number(soft.movers[i])]);
}

/// The square of a sum of velocities is at most the sum of their squares times weights / weight.
void ContactMovers::add_slopes(int point, const Vector3d& arm_m, const Vector3d& normal,
                               const ImpulseSlopes& slopes, double weights) {
  if (point == 0) return;
  const std::size_t place = number(point) - 1;
  const double across_kg = weights * slopes.across_kg;
  const double more_kg = weights * (slopes.normal_kg - slopes.across_kg);
  if (place < rigid_movers_.size()) {
    if (!rigid_movers_[place].is_widened) return;
    // With L the lever's cross matrix: L I, L n and L L^T = r^2 I - r r^T, in closed form.
    Matrix6& response = rigid_movers_[place].response;
    const Vector3d moment = arm_m.cross(normal), by_normal = more_kg * normal;
    response.topLeftCorner<3, 3>() += by_normal * normal.transpose();
    response.bottomLeftCorner<3, 3>() +=
        moment * by_normal.transpose() + across_kg * bodies::cross_matrix(arm_m);
    response.bottomRightCorner<3, 3>() +=
        (more_kg * moment) * moment.transpose() - (across_kg * arm_m) * arm_m.transpose();
    response.diagonal().head<3>().array() += across_kg;
    response.diagonal().tail<3>().array() += across_kg * arm_m.squaredNorm();
    return;
  }
  const SoftPoint& soft = soft_[place - rigid_movers_.size()];
  const Matrix3d block = across_kg * Matrix3d::Identity() + more_kg * normal * normal.transpose();
  for (std::size_t i = 0; i < number(soft.node_count); ++i) {
    if (number(soft.movers[i]) >= node_movers_.size()) continue;
    NodeMover& mover = node_movers_[number(soft.movers[i])];
    if (mover.is_widened) mover.response += std::abs(soft.weights[i]) * block;
  }
}

double ContactMovers::invert_responses(const ContactIsland& island, const ExplicitState& state) {
  double ratio = 0.0;
  for (RigidMover& mover : rigid_of(island)) {
    if (mover.is_widened) {
      const RigidState& body = state.rigid[number(mover.rigid)];
      Matrix6& own = mover.response;
      const Matrix3d turning = body.inverse_inertia_per_kg_m2 * own.bottomRightCorner<3, 3>();
      mover.ratio = body.inverse_mass_per_kg * own.topLeftCorner<3, 3>().norm() +
                    std::sqrt(turning.cwiseProduct(turning.transpose()).sum());
      own.topLeftCorner<3, 3>() += Matrix3d::Identity() / body.inverse_mass_per_kg;
      own.bottomRightCorner<3, 3>() += mover.inertia_kg_m2;
      invert(own);
    }
    ratio = std::max(ratio, mover.ratio);
  }
  for (NodeMover& mover : nodes_of(island)) {
    if (mover.is_widened) {
      const double inverse_mass_per_kg = state.inverse_mass_per_kg[number(mover.node)];
      mover.ratio = inverse_mass_per_kg * mover.response.norm();
      mover.response.diagonal().array() += 1.0 / inverse_mass_per_kg;
      mover.response = mover.response.inverse().eval();
    }
    ratio = std::max(ratio, mover.ratio);
  }
  return ratio;
}

ContactResidual ContactMovers::residual(const ContactIsland& island, const ExplicitState& state) {
  ContactResidual result;
  double along = 0.0;
  for (RigidMover& mover : rigid_of(island)) {
    const RigidState& body = state.rigid[number(mover.rigid)];
    Vector6 asked, made;
    asked << body.inverse_mass_per_kg * mover.impulse.head<3>(),
        body.inverse_inertia_per_kg_m2 * mover.impulse.tail<3>();
    made << body.velocity_m_s, body.spin_rad_s;
    const Vector6 change = made - mover.start;
    made -= mover.free;
    const Vector6 left = asked - made;
    const auto speed_m_s = [&](const Vector6& v) {
      return v.head<3>().norm() + mover.arm_m * v.tail<3>().norm();
    };
    result.left_m_s = larger(result.left_m_s, speed_m_s(left));
    result.change_m_s = larger(result.change_m_s, speed_m_s(change));
    mover.residual << left.head<3>() / body.inverse_mass_per_kg,
        mover.impulse.tail<3>() - mover.inertia_kg_m2 * made.tail<3>();
    along += mover.direction.dot(mover.residual);
  }
  double left_m2_s2 = 0.0, change_m2_s2 = 0.0;
  for (std::size_t i = island.nodes.first; i < island.nodes.last; ++i) {
    NodeMover& mover = node_movers_[i];
    const std::size_t node = number(mover.node);
    const double inverse_mass_per_kg = state.inverse_mass_per_kg[node];
    const Vector3d now_m_s = state.velocity_m_s[node].map();
    const Vector3d left = inverse_mass_per_kg * node_impulse_N_s_[i].map() - (now_m_s - mover.free);
    left_m2_s2 = larger(left_m2_s2, left.squaredNorm());
    change_m2_s2 = larger(change_m2_s2, (now_m_s - mover.start).squaredNorm());
    mover.residual = 1.0 / inverse_mass_per_kg * left;
    along += mover.direction.dot(mover.residual);
  }
  result.left_m_s = larger(result.left_m_s, std::sqrt(left_m2_s2));
  result.change_m_s = larger(result.change_m_s, std::sqrt(change_m2_s2));
  result.is_uphill = along < 0.0;
  return result;
}

void ContactMovers::advance(const ContactIsland& island, double momentum_weight,
                            double residual_weight, ExplicitState& state) {
  for (RigidMover& mover : rigid_of(island)) {
    RigidState& body = state.rigid[number(mover.rigid)];
    mover.direction =
        momentum_weight * mover.direction + residual_weight * (mover.response * mover.residual);
    body.velocity_m_s += mover.direction.head<3>();
    body.spin_rad_s += mover.direction.tail<3>();
  }
  for (NodeMover& mover : nodes_of(island)) {
    mover.direction =
        momentum_weight * mover.direction + residual_weight * (mover.response * mover.residual);
    state.velocity_m_s[number(mover.node)].map() += mover.direction;
  }
}

void ContactMovers::apply(ExplicitState& state) const {
  for (const RigidMover& mover : rigid_movers_) {
    RigidState& body = state.rigid[number(mover.rigid)];
    body.velocity_m_s = mover.free.head<3>() + body.inverse_mass_per_kg * mover.impulse.head<3>();
    body.angular_momentum_N_m_s += mover.impulse.tail<3>();
    body.spin_rad_s = body.inverse_inertia_per_kg_m2 * body.angular_momentum_N_m_s;
  }
  for (std::size_t i = 0; i < node_movers_.size(); ++i) {
    const std::size_t node = number(node_movers_[i].node);
    state.velocity_m_s[node].map() =
        node_movers_[i].free + state.inverse_mass_per_kg[node] * node_impulse_N_s_[i].map();
  }
}

}  // namespace stillgrid::dynamics
