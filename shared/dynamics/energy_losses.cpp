#include "shared/dynamics/energy_losses.hpp"

#include <algorithm>

#include "shared/dynamics/at.hpp"

namespace stillgrid::dynamics {
namespace {

Eigen::Vector3d vector_of(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}

/// Velocity of one side of a contact at its point. sign: +1 for side a, -1 for side b.
Eigen::Vector3d side_velocity_m_s(const RowList& list, const ContactBodies& bodies, SideKind kind,
                                  std::size_t side, std::size_t row, std::size_t lane, int sign) {
  const ContactRow& contact = list.rows[row];
  const Mover& mover = bodies.movers[at((sign > 0 ? contact.mover_a : contact.mover_b)[lane])];
  switch (kind) {
    case SideKind::kBall:
      return vector_of(mover.velocity_m_s) -
             sign * static_cast<double>(contact.lever[lane]) *
                 vector_of(mover.spin).cross(lane_of(contact.normal, lane));
    case SideKind::kRigid:
      return vector_of(mover.velocity_m_s) +
             vector_of(mover.spin).cross(lane_of(list.rigid_sides[side].arm_m, lane));
    case SideKind::kSoft: {
      const SoftSide& soft = list.soft_sides[side];
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t k = 0; k < 4; ++k)
        sum += static_cast<double>(soft.weight[k][lane]) *
               vector_of(bodies.movers[at(soft.node[k][lane])].velocity_m_s);
      return sum;
    }
    case SideKind::kPlane:
      break;
  }
  return Eigen::Vector3d::Zero();
}

double stretch_square_m2(const RowPlace& place, std::size_t lane) {
  return lane_of(place.stretch_m, lane).squaredNorm();
}

/// Calls visit(group, number, row, lane, relative velocity) for all lanes of live rows.
template <class Visit>
void each_lane(const RowList& list, const ContactBodies& bodies, const LiveRows& live,
               const Visit& visit) {
  std::size_t number = 0;
  for (std::size_t g = 0, i = 0; g < list.groups.size(); ++g) {
    const RowGroup& group = list.groups[g];
    for (; i < live.group_end[g]; ++i) {
      const std::size_t row = live.rows[i], k = row - group.first;
      for (std::size_t lane = 0; lane < kRowLanes; ++lane)
        visit(g, number++, row, lane,
              side_velocity_m_s(list, bodies, group.a, group.first_side_a + k, row, lane, 1) -
                  side_velocity_m_s(list, bodies, group.b, group.first_side_b + k, row, lane, -1));
    }
  }
}

/// Of one contact. u0, u1: relative velocities at both ends.
EnergyLosses contact_losses(const ContactRow& row, const RowPlace& place, std::size_t lane,
                            const Eigen::Vector3d& u0, const Eigen::Vector3d& u1,
                            double start_stretch_m2, double h) {
  const Eigen::Vector3d normal = lane_of(row.normal, lane), mean = 0.5 * (u0 + u1);
  const double k = place.stiffness_N_per_m[lane], middle_m = row.depth_m[lane];
  const double push = row.push_impulse_N_s[lane];
  const double start_m = std::max(0.0, middle_m + 0.5 * h * u0.dot(normal));
  const double end_m = std::max(0.0, middle_m - 0.5 * h * u1.dot(normal));
  const double asked = static_cast<double>(row.damper_N_s_per_m[lane]) * (end_m - start_m);
  const double damper = std::clamp(asked, 0.0, push), apart = mean.dot(normal);
  const Eigen::Vector3d drag = lane_of(row.friction_impulse_N_s, lane);
  EnergyLosses losses;
  losses.contact_damping_J = -damper * apart;
  losses.friction_J =
      0.5 * k * (start_stretch_m2 - stretch_square_m2(place, lane)) - drag.dot(mean);
  losses.unsolved_J = 0.5 * k * (end_m * end_m - start_m * start_m) + (push - damper) * apart;
  return losses;
}

}  // namespace

Description dampers_of(const Description& description) {
  Description dampers;
  dampers.nodes = description.nodes;
  dampers.rigid_bodies = description.rigid_bodies;
  for (Description::Spring spring : description.springs) {
    spring.stiffness_N_per_m = 0.0;
    if (spring.damping_N_s_per_m > 0.0) dampers.springs.push_back(spring);
  }
  for (Description::Joint joint : description.joints) {
    joint.stiffness_N_per_m = 0.0;
    if (joint.damping_N_s_per_m > 0.0) dampers.joints.push_back(joint);
  }
  return dampers;
}

EnergyLosses& EnergyLosses::operator+=(const EnergyLosses& more) {
  spring_damping_J += more.spring_damping_J;
  contact_damping_J += more.contact_damping_J;
  friction_J += more.friction_J;
  unsolved_J += more.unsolved_J;
  return *this;
}

LossMeter::LossMeter(const Description& description)
    : dampers_(dampers_of(description)),
      table_(dampers_),
      node_forces_N_(description.nodes.size()),
      wrenches_(dampers_.joints.empty() ? 0 : description.rigid_bodies.size()) {}

void LossMeter::start(const SceneState& state, const RowList& list, const ContactBodies& bodies,
                      const LiveRows& live) {
  std::fill(node_forces_N_.begin(), node_forces_N_.end(), Vector4());
  if (!dampers_.springs.empty())
    table_.add_forces(state.node_position_m, state.node_velocity_m_s, node_forces_N_);
  std::fill(wrenches_.begin(), wrenches_.end(), Wrench());
  add_joint_forces(dampers_.joints, state, node_forces_N_, wrenches_);
  node_velocity_m_s_ = state.node_velocity_m_s;
  rigid_velocity_m_s_ = state.rigid_velocity_m_s;
  angular_velocity_rad_s_ = state.angular_velocity_rad_s;
  starts_.resize(live.rows.size() * kRowLanes);
  each_lane(list, bodies, live,
            [&](std::size_t, std::size_t number, std::size_t row, std::size_t lane,
                const Eigen::Vector3d& u) {
              starts_[number] = {u, stretch_square_m2(list.places[row], lane)};
            });
}

void LossMeter::finish(const SceneState& state, const RowList& list, const ContactBodies& bodies,
                       const LiveRows& live, double h) {
  finish_dampers(state, h);
  each_lane(list, bodies, live,
            [&](std::size_t group, std::size_t number, std::size_t row, std::size_t lane,
                const Eigen::Vector3d& u) {
              if (is_between_driven(list.groups[group], list.rows[row], bodies, lane)) return;
              const Start& start = starts_[number];
              losses_ += contact_losses(list.rows[row], list.places[row], lane, start.velocity_m_s,
                                        u, start.stretch_square_m2, h);
            });
}

void LossMeter::finish_dampers(const SceneState& state, double h) {
  const auto mean = [](const Vector4& a, const Vector4& b) { return (0.5 * (a + b)).vector(); };
  double power_W = 0.0;
  for (std::size_t i = 0; i < node_forces_N_.size(); ++i)
    power_W +=
        node_forces_N_[i].vector().dot(mean(node_velocity_m_s_[i], state.node_velocity_m_s[i]));
  for (std::size_t r = 0; r < wrenches_.size(); ++r)
    power_W += wrenches_[r].force_N.dot(mean(rigid_velocity_m_s_[r], state.rigid_velocity_m_s[r])) +
               wrenches_[r].torque_N_m.dot(
                   mean(angular_velocity_rad_s_[r], state.angular_velocity_rad_s[r]));
  losses_.spring_damping_J -= h * power_W;
}

}  // namespace stillgrid::dynamics
