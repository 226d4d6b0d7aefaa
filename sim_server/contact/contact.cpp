#include "sim_server/contact/contact.hpp"

#include <algorithm>

#include "sim_server/bodies/rotation.hpp"
#include "sim_server/contact/sticking.hpp"

namespace stillgrid::contact {
namespace {

/// Direction, depth and lever of a contact, and how the direction turns as a moves.
struct Geometry {
  double depth_m;
  Eigen::Vector3d normal;  // towards a
  Eigen::Vector3d arm_m;
  double turn_per_m;  // 1 / distance of the centres; a plane's normal does not turn
  double arm_moves;   // 1: the arm is the line of centres; 0: it is fixed
};

Geometry geometry_of(const Contact& contact, const Eigen::Vector3d& position_m) {
  if (contact.is_plane) {
    const double height_m = contact.plane_normal.dot(position_m) - contact.plane_offset_m;
    return {contact.radius_a_m - height_m, contact.plane_normal,
            contact.radius_a_m * contact.plane_normal, 0.0, 0.0};
  }
  const double distance_m = position_m.norm();
  const double depth_m = contact.radius_a_m + contact.radius_b_m - distance_m;
  // Concentric spheres push along any one direction: up.
  if (distance_m < 1e-12) return {depth_m, Eigen::Vector3d::UnitZ(), position_m, 0.0, 1.0};
  return {depth_m, position_m / distance_m, position_m, 1.0 / distance_m, 1.0};
}

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Along what a contact presses, and how that turns as a moves.
struct Pressure {
  Vector3d direction;
  Matrix3d by_position = Matrix3d::Zero();  // 1/m
};

Pressure pressure_of(const Contact& contact, const ContactMotion& motion, const Geometry& geometry,
                     const Matrix3d& across) {
  const Vector3d& n = geometry.normal;
  if (!motion.start_m || contact.is_plane || !(contact.depth_before_m > 0.0))
    return {n, geometry.turn_per_m * across};
  const Vector3d sum = motion.start_m->normalized() + n;
  const double length = sum.norm();
  // Beyond a right angle they passed through one another.
  if (length < 1.5) return {n, geometry.turn_per_m * across};
  const Vector3d mean = sum / length;
  return {mean,
          geometry.turn_per_m / length * (Matrix3d::Identity() - mean * mean.transpose()) * across};
}

/// How the part across the normal of a vector that stays as it is changes as a moves.
Matrix3d across_by_position(const Geometry& geometry, const Matrix3d& across,
                            const Vector3d& vector) {
  const Vector3d& n = geometry.normal;
  return -geometry.turn_per_m * (n.dot(vector) * across + n * (vector.transpose() * across));
}

/// Friction on a, and how it changes.
struct Friction {
  Vector3d force_N = Vector3d::Zero();
  Vector3d stretch_m = Vector3d::Zero();
  Vector3d by_load = Vector3d::Zero();     // with the normal force
  Matrix3d by_slip = Matrix3d::Zero();     // with the velocity of the points of contact
  Matrix3d by_stretch = Matrix3d::Zero();  // with what it began with
};

Friction viscous_friction(const collision::ContactMaterial& material, double normal_load_N,
                          const Vector3d& slip_m_s) {
  Friction friction;
  friction.force_N = collision::friction_force_N(material, normal_load_N, slip_m_s);
  const double slip_norm_m_s = slip_m_s.norm();
  const double scale_m_s = std::max(slip_norm_m_s, material.slip_speed_m_s);
  const Vector3d direction = slip_m_s / scale_m_s;
  friction.by_load = -material.friction * direction;
  friction.by_slip = -material.friction * normal_load_N / scale_m_s * Matrix3d::Identity();
  if (slip_norm_m_s > material.slip_speed_m_s)
    friction.by_slip +=
        material.friction * normal_load_N / scale_m_s * direction * direction.transpose();
  return friction;
}

Friction sticking_friction(const collision::ContactMaterial& material, double normal_load_N,
                           const Vector3d& stretch_m, double time_s, const Vector3d& slip_m_s,
                           double step_s) {
  Friction friction;
  const double most_N = material.friction * normal_load_N;
  const StickingForce held = sticking_force(material, stretch_m, time_s * slip_m_s, most_N, step_s);
  friction.force_N = held.force_N;
  friction.stretch_m = held.stretch_m;
  Matrix3d gives = held.share * Matrix3d::Identity();
  if (held.share < 1.0) {
    const Vector3d direction = -held.force_N.normalized();
    friction.by_load = -material.friction * direction;
    gives -= held.share * direction * direction.transpose();
  }
  friction.by_slip =
      -time_s * (material.stiffness_N_per_m + material.damping_N_s_per_m / step_s) * gives;
  friction.by_stretch = -material.stiffness_N_per_m * gives;
  return friction;
}

}  // namespace

SideMotion kinematic_side(const Contact& contact) {
  return {contact.position_b_m, contact.velocity_b_m_s, contact.spin_b_rad_s};
}

ContactMotion relative_motion(const Contact& contact, const SideMotion& a, const SideMotion& b) {
  const ContactShares shares = contact_shares(contact);
  // A plane's place is in its offset.
  const Eigen::Vector3d position_m =
      contact.is_plane ? a.position_m : Eigen::Vector3d(a.position_m - b.position_m);
  return {position_m, a.velocity_m_s - b.velocity_m_s,
          shares.a * a.spin_rad_s + shares.b * b.spin_rad_s};
}

ContactShares contact_shares(const Contact& contact) {
  if (contact.is_plane) return {1.0, 0.0};
  const double share_a = contact.radius_a_m / (contact.radius_a_m + contact.radius_b_m);
  return {share_a, 1.0 - share_a};
}

double contact_depth_m(const Contact& contact, const Eigen::Vector3d& position_m) {
  return geometry_of(contact, position_m).depth_m;
}

ContactForce contact_force(const Contact& contact, const ContactMotion& motion, double step_s,
                           ContactDerivatives* derivatives) {
  const Geometry geometry = geometry_of(contact, motion.position_m);
  ContactForce result;
  result.depth_m = geometry.depth_m;
  if (!(geometry.depth_m > 0.0)) return result;

  const collision::ContactMaterial& material = contact.material;
  const Eigen::Vector3d& n = geometry.normal;
  const double deepening_m = geometry.depth_m - std::max(contact.depth_before_m, 0.0);
  const double separation_m_s = n.dot(motion.velocity_m_s);
  const double approach_m_s = step_s > 0.0 ? deepening_m / step_s : -separation_m_s;
  const double normal_load_N = collision::normal_force_N(material, geometry.depth_m, approach_m_s);
  const Matrix3d across = Matrix3d::Identity() - n * n.transpose();
  const Vector3d slip_m_s = across * motion.velocity_m_s - motion.spin_rad_s.cross(geometry.arm_m);
  const Friction friction =
      motion.sticking
          ? sticking_friction(material, normal_load_N, across * motion.sticking->stretch_m,
                              motion.sticking->time_s, slip_m_s, step_s)
          : viscous_friction(material, normal_load_N, slip_m_s);
  result.touching = true;
  result.arm_m = geometry.arm_m;
  result.friction_N = friction.force_N;
  result.stretch_m = friction.stretch_m;
  const Pressure pressure = pressure_of(contact, motion, geometry, across);
  result.force_N = normal_load_N * pressure.direction + result.friction_N;
  if (derivatives == nullptr) return result;

  const double hardness_N_per_m =
      material.stiffness_N_per_m + (deepening_m > 0.0 ? material.damping_N_s_per_m / step_s : 0.0);
  const Eigen::RowVector3d normal_load_by_position = -hardness_N_per_m * n.transpose();
  const Matrix3d lever = bodies::cross_matrix(geometry.arm_m);

  derivatives->friction_by_position =
      friction.by_load * normal_load_by_position +
      friction.by_slip * (across_by_position(geometry, across, motion.velocity_m_s) -
                          geometry.arm_moves * bodies::cross_matrix(motion.spin_rad_s));
  if (motion.sticking)
    derivatives->friction_by_position +=
        friction.by_stretch * across_by_position(geometry, across, motion.sticking->stretch_m);
  derivatives->friction_by_velocity = friction.by_slip * across;
  derivatives->friction_by_spin = friction.by_slip * lever;
  derivatives->force_by_position = derivatives->friction_by_position +
                                   pressure.direction * normal_load_by_position +
                                   normal_load_N * pressure.by_position;
  derivatives->force_by_velocity = derivatives->friction_by_velocity;
  derivatives->force_by_spin = derivatives->friction_by_spin;
  derivatives->arm_by_position = geometry.arm_moves * Matrix3d::Identity();
  derivatives->normal_stiffness_N_per_m = hardness_N_per_m * n * n.transpose();
  derivatives->drag_N_s_per_m = -friction.by_slip;
  derivatives->across = across;
  derivatives->sideways_softness_N_per_m = 0.5 * normal_load_N * pressure.by_position.trace();
  return result;
}

}  // namespace stillgrid::contact
