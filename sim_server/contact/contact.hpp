#pragma once

#include <Eigen/Core>
#include <optional>

#include "shared/collision/contact_law.hpp"

namespace stillgrid::contact {

/// A possible contact during one step: two moving spheres, or a moving sphere and something given:
/// a static sphere, a plane or a sphere of the tool. In place of a moving sphere may be a field, by
/// its number (bodies::is_field): met_at() says what sphere that is at any moment.
struct Contact {
  int a = 0;       // moving sphere, index into World::spheres, or a field
  int b = -1;      // likewise, or -1: the fields below
  int other = -1;  // where b is -1: which static sphere, plane or sphere of the tools it is
  collision::ContactMaterial material;
  double radius_a_m = 0.0;
  double radius_b_m = 0.0;        // zero for a plane
  double depth_before_m = 0.0;    // overlap at the start of the step, negative: a gap
  double map_scale_before = 1.0;  // of a field, there: over the material's stiffness

  // A given sphere's centre at the step's end and at its start.
  Eigen::Vector3d position_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d start_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_b_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin_b_rad_s = Eigen::Vector3d::Zero();
  bool is_tool = false;
  bool is_plane = false;
  int hand = 0;  // of a tool: whose
  Eigen::Vector3d plane_normal = Eigen::Vector3d::Zero();
  double plane_offset_m = 0.0;
};

/// What sticking friction goes by: how it was stretched as the step began, of a seen from b, and
/// the time since, in which the points of contact are taken to have slid as they do at its end.
struct Sticking {
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();
  double time_s = 0.0;
};

/// Relative motion in a contact, of a seen from b.
struct ContactMotion {
  Eigen::Vector3d position_m;             // centre of a minus centre of b; plane: centre of a
  Eigen::Vector3d velocity_m_s;           // of the centres
  Eigen::Vector3d spin_rad_s;             // share_a * spin_a + share_b * spin_b
  std::optional<Sticking> sticking = {};  // none: friction is viscous below the slip speed
  // As position_m, when the step began; none: pressure is along the normal at its end.
  std::optional<Eigen::Vector3d> start_m = {};
};

/// One side of a contact.
struct SideMotion {
  Eigen::Vector3d position_m;  // of the sphere's centre
  Eigen::Vector3d velocity_m_s;
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
};

/// The given side of a contact at the end of the step. Pre: contact.b is -1.
[[nodiscard]] SideMotion kinematic_side(const Contact& contact);

[[nodiscard]] ContactMotion relative_motion(const Contact& contact, const SideMotion& a,
                                            const SideMotion& b);

/// Shares of the line between the centres on either side of the point of contact; they sum to one.
struct ContactShares {
  double a, b;
};
[[nodiscard]] ContactShares contact_shares(const Contact& contact);

/// Overlap where a's centre is position_m from b's; for a plane, from the origin. Negative: a gap.
[[nodiscard]] double contact_depth_m(const Contact& contact, const Eigen::Vector3d& position_m);

/// Force on a, its friction part, and how both change with the relative motion.
struct ContactForce {
  bool touching = false;
  double depth_m = 0.0;
  Eigen::Vector3d arm_m =
      Eigen::Vector3d::Zero();  // share * arm: from the point of contact to a centre
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d friction_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // at the step's end, of what sticks
};
struct ContactDerivatives {
  Eigen::Matrix3d force_by_position, force_by_velocity, force_by_spin;
  Eigen::Matrix3d friction_by_position, friction_by_velocity, friction_by_spin;
  Eigen::Matrix3d arm_by_position;

  // What resists: the part that is symmetric and definite.
  Eigen::Matrix3d normal_stiffness_N_per_m;  // along the normal
  Eigen::Matrix3d drag_N_s_per_m;            // of friction on the slip
  Eigen::Matrix3d across;                    // projects a velocity on the plane of contact
  // What gives way: sideways, pressure pushes further, as the normal turns.
  double sideways_softness_N_per_m;
};

/// The contact law over one implicit step of step_s.
///
/// Spring and friction are taken at the step's end. The approach damper acts over that part of the
/// step in which the spheres overlap: its rate is (depth - max(depth before, 0)) / step. That is
/// the mean of the law's force over the step, tends to the law as the step shrinks, and unlike the
/// law itself grows from zero at touch, so that a solver can converge on a stiff onset.
///
/// Friction that sticks is a spring of the contact's own stiffness with its own damper, stretched
/// as the points of contact slide, and in line with them something that gives way at friction times
/// the normal force [Cundall, Strack 1979]: what rests on it rests. They slide by the time times
/// their velocity at the step's end, not by the chord of their way: what slides is so held against
/// its velocity, and an implicit Euler step is given no energy however far its bodies turn.
///
/// Spheres that overlap when the step begins press along the mean of the normals at its start and
/// its end: so they do the work that their spring has lost, and no more, however far they go round
/// one another (a discrete gradient [Gonzalez 1996], but for the depth, which is the end's).
///
/// A step_s of zero asks for the law itself, the damper by the velocities; without derivatives
/// and without sticking then.
///
/// derivatives: filled in when not null and touching; exact but at the law's kinks.
[[nodiscard]] ContactForce contact_force(const Contact& contact, const ContactMotion& motion,
                                         double step_s, ContactDerivatives* derivatives);

}  // namespace stillgrid::contact
