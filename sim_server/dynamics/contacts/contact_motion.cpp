// How bodies and nodes move under what contacts push, iteration by iteration.

#include <algorithm>
#include <cmath>

#include "sim_server/dynamics/contacts/contact_movers.hpp"

namespace stillgrid::dynamics {
namespace {

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

std::size_t count(const ContactIsland::Range& range) {
  return range.last - range.first;
}

Vector6 velocity_of(const ContactPoint& point) {
  Vector6 velocity;
  velocity << point.linear.map(), point.angular.map();
  return velocity;
}

void set_velocity(const Vector6& velocity, ContactPoint& point) {
  point.linear.map() = velocity.head<3>();
  point.angular.map() = velocity.tail<3>();
}

}  // namespace

void ContactResidual::add(const ContactResidual& more) {
  left_m_s = larger(left_m_s, more.left_m_s);
  change_m_s = larger(change_m_s, more.change_m_s);
  along_J += more.along_J;
}

void ContactMovers::note_start(const ExplicitState& state, const Workers& workers) {
  workers.for_each(rigid_movers_.size(), kMoversAChunk, [&](std::size_t i) {
    RigidMover& mover = rigid_movers_[i];
    const RigidState& body = state.rigid[static_cast<std::size_t>(mover.rigid)];
    mover.start << body.velocity_m_s, body.spin_rad_s;
    set_velocity(mover.start, velocities_[1 + i]);
  });
  for (NodeMover& mover : node_movers_)
    mover.start = state.velocity_m_s[static_cast<std::size_t>(mover.node)].map();
  for (const ContactIsland& island : islands_) place_soft(island, state);
}

void ContactMovers::reach(std::span<const ContactRows> rows, const Workers& workers) {
  const auto farthest_m = [&](std::size_t point) {
    double most_m2 = 0.0;
    for (const TouchSide side : sides_of(point)) {
      const ContactRows& own = rows[side.lane / ContactRows::kLanes];
      const std::size_t lane = side.lane % ContactRows::kLanes;
      most_m2 = std::max(
          most_m2, ContactRows::get(side.is_b ? own.arm_b_m : own.arm_a_m, lane).squaredNorm());
    }
    return std::sqrt(most_m2);
  };
  workers.for_each(rigid_movers_.size(), kMoversAChunk,
                   [&](std::size_t i) { rigid_movers_[i].arm_m = farthest_m(1 + i); });
}

void ContactMovers::start(ExplicitState& state, const Workers& workers) {
  // At rest the velocities before all forces are the solution, to rounding.
  workers.for_each(rigid_movers_.size(), kMoversAChunk, [&](std::size_t i) {
    RigidMover& mover = rigid_movers_[i];
    const RigidState& body = state.rigid[static_cast<std::size_t>(mover.rigid)];
    mover.free << body.velocity_m_s, body.spin_rad_s;
    mover.inverse_mass_per_kg = body.inverse_mass_per_kg;
    mover.inverse_inertia_per_kg_m2 = body.inverse_inertia_per_kg_m2;
    mover.inertia_kg_m2 = body.inverse_inertia_per_kg_m2.inverse();
    mover.direction.setZero();
  });
  for (NodeMover& mover : node_movers_) {
    auto velocity_m_s = state.velocity_m_s[static_cast<std::size_t>(mover.node)].map();
    mover.free = velocity_m_s;
    velocity_m_s = mover.start;
    mover.direction.setZero();
  }
}

double ContactMovers::largest_m_s(const ContactIsland& island) const {
  double largest_m2_s2 = 0.0;
  for (std::size_t i = island.rigid.first; i < island.rigid.last; ++i)
    largest_m2_s2 = std::max(largest_m2_s2, rigid_movers_[i].free.head<3>().squaredNorm());
  for (std::size_t i = island.nodes.first; i < island.nodes.last; ++i)
    largest_m2_s2 = std::max(largest_m2_s2, node_movers_[i].free.squaredNorm());
  return std::sqrt(largest_m2_s2);
}

void ContactMovers::place_soft(const ContactIsland& island, const ExplicitState& state) {
  const std::size_t soft = 1 + rigid_movers_.size();
  for (std::size_t i = island.soft.first; i < island.soft.last; ++i) {
    const SoftPoint& point = soft_[i];
    Four sum_m_s = Four::Zero();
    for (std::size_t k = 0; k < static_cast<std::size_t>(point.node_count); ++k)
      sum_m_s +=
          point.weights[k] * four(state.velocity_m_s[static_cast<std::size_t>(point.nodes[k])]);
    four(velocities_[soft + i].linear) = sum_m_s;
  }
}

/// The sum of what pushes a point, in the order of lanes.
ContactPoint ContactMovers::pushed(std::size_t point, std::span<const ContactPush> pushes) const {
  Four linear = Four::Zero(), angular = Four::Zero();
  for (const TouchSide side : sides_of(point)) {
    const ContactPush& push = pushes[side.lane];
    const double sign = side.is_b ? -1.0 : 1.0;
    linear += sign * four(push.linear);
    angular += sign * four(side.is_b ? push.moment_b : push.moment_a);
  }
  ContactPoint sum;
  four(sum.linear) = linear;
  four(sum.angular) = angular;
  return sum;
}

void ContactMovers::push_nodes(const ContactIsland& island, std::span<const ContactPush> pushes) {
  for (std::size_t i = island.nodes.first; i < island.nodes.last; ++i) node_impulse_N_s_[i] = {};
  for (std::size_t i = island.soft.first; i < island.soft.last; ++i) {
    const SoftPoint& point = soft_[i];
    const ContactPoint push = pushed(1 + rigid_movers_.size() + i, pushes);
    for (std::size_t k = 0; k < static_cast<std::size_t>(point.node_count); ++k) {
      const auto mover = static_cast<std::size_t>(point.movers[k]);
      if (mover < node_movers_.size())
        four(node_impulse_N_s_[mover]) += point.weights[k] * four(push.linear);
    }
  }
}

ContactResidual ContactMovers::body_residual(std::size_t i, std::span<const ContactPush> pushes) {
  RigidMover& mover = rigid_movers_[i];
  const ContactPoint& impulse = impulses_[1 + i] = pushed(1 + i, pushes);
  const Vector6 now = velocity_of(velocities_[1 + i]);
  const Vector6 made = now - mover.free, change = now - mover.start;
  Vector6 asked;
  asked << mover.inverse_mass_per_kg * impulse.linear.map(),
      mover.inverse_inertia_per_kg_m2 * impulse.angular.map();
  const Vector6 left = asked - made;
  const auto speed_m_s = [&](const Vector6& v) {
    return v.head<3>().norm() + mover.arm_m * v.tail<3>().norm();
  };
  mover.residual << left.head<3>() / mover.inverse_mass_per_kg,
      impulse.angular.map() - mover.inertia_kg_m2 * made.tail<3>();
  return {speed_m_s(left), speed_m_s(change), mover.direction.dot(mover.residual)};
}

ContactResidual ContactMovers::node_residual(std::size_t i, const ExplicitState& state) {
  NodeMover& mover = node_movers_[i];
  const auto node = static_cast<std::size_t>(mover.node);
  const double inverse_mass_per_kg = state.inverse_mass_per_kg[node];
  const Vector3d now_m_s = state.velocity_m_s[node].map();
  const Vector3d left = inverse_mass_per_kg * node_impulse_N_s_[i].map() - (now_m_s - mover.free);
  mover.residual = 1.0 / inverse_mass_per_kg * left;
  return {left.norm(), (now_m_s - mover.start).norm(), mover.direction.dot(mover.residual)};
}

ContactResidual ContactMovers::residual(const ContactIsland& island,
                                        std::span<const ContactPush> pushes,
                                        const ExplicitState& state, const Workers& workers) {
  push_nodes(island, pushes);
  std::size_t chunk = island.first_chunk;
  const auto add_up = [&](const ContactIsland::Range& range, const auto& residual_of) {
    workers.for_each_chunk(count(range), kMoversAChunk, [&](std::size_t first, std::size_t last) {
      ContactResidual sum;
      for (std::size_t i = first; i < last; ++i) sum.add(residual_of(range.first + i));
      residuals_[chunk + first / kMoversAChunk] = sum;
    });
    chunk += Workers::chunks_of(count(range), kMoversAChunk);
  };
  add_up(island.rigid, [&](std::size_t i) { return body_residual(i, pushes); });
  add_up(island.nodes, [&](std::size_t i) { return node_residual(i, state); });
  ContactResidual result;
  for (std::size_t i = island.first_chunk; i < chunk; ++i) result.add(residuals_[i]);
  return result;
}

void ContactMovers::advance(const ContactIsland& island, double momentum_weight,
                            double residual_weight, ExplicitState& state, const Workers& workers) {
  const auto lead_on = [&](auto& mover, const auto& response) {
    mover.direction =
        momentum_weight * mover.direction + residual_weight * (response.matrix * mover.residual);
  };
  workers.for_each(count(island.rigid), kMoversAChunk, [&](std::size_t k) {
    const std::size_t i = island.rigid.first + k;
    RigidMover& mover = rigid_movers_[i];
    lead_on(mover, rigid_responses_[i]);
    velocities_[1 + i].linear.map() += mover.direction.head<3>();
    velocities_[1 + i].angular.map() += mover.direction.tail<3>();
  });
  for (std::size_t i = island.nodes.first; i < island.nodes.last; ++i) {
    NodeMover& mover = node_movers_[i];
    lead_on(mover, node_responses_[i]);
    state.velocity_m_s[static_cast<std::size_t>(mover.node)].map() += mover.direction;
  }
  place_soft(island, state);
}

void ContactMovers::apply(ExplicitState& state, const Workers& workers) {
  workers.for_each(rigid_movers_.size(), kMoversAChunk, [&](std::size_t i) {
    const RigidMover& mover = rigid_movers_[i];
    const ContactPoint& impulse = impulses_[1 + i];
    RigidState& body = state.rigid[static_cast<std::size_t>(mover.rigid)];
    body.velocity_m_s = mover.free.head<3>() + mover.inverse_mass_per_kg * impulse.linear.map();
    body.angular_momentum_N_m_s += impulse.angular.map();
    body.spin_rad_s = body.inverse_inertia_per_kg_m2 * body.angular_momentum_N_m_s;
    velocities_[1 + i].linear.map() = body.velocity_m_s;
    velocities_[1 + i].angular.map() = body.spin_rad_s;
  });
  for (std::size_t i = 0; i < node_movers_.size(); ++i) {
    const auto node = static_cast<std::size_t>(node_movers_[i].node);
    state.velocity_m_s[node].map() =
        node_movers_[i].free + state.inverse_mass_per_kg[node] * node_impulse_N_s_[i].map();
  }
  for (const ContactIsland& island : islands_) place_soft(island, state);
}

}  // namespace stillgrid::dynamics
