#pragma once

#include <Eigen/Core>

namespace stillgrid::collision {

/// The constants of one contact.
struct ContactMaterial {
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;  // acts while the spheres approach
  double friction = 0.0;           // Coulomb's coefficient
  double slip_speed_m_s = 1e-3;    // below it friction is viscous
};

/// The constants between two materials: harmonic means of stiffness and of damping, the smaller
/// friction and the larger slip speed. A contact with the tool, which has no material, has the
/// touched body's.
[[nodiscard]] ContactMaterial pair_material(const ContactMaterial& a,
                                            const ContactMaterial& b) noexcept;

/// The constants of a contact with a tool that has no proxy: the touched body's, but friction is
/// viscous at least up to tool_slip_speed_m_s.
[[nodiscard]] ContactMaterial tool_material(ContactMaterial touched,
                                            double tool_slip_speed_m_s) noexcept;

/// Magnitude of the force that pushes two bodies apart: a spring on the depth and, while they
/// approach, a damper [Davanne 2002, "Collision response"]. Zero without overlap, never negative.
/// Realtime: yes.
[[nodiscard]] double normal_force_N(const ContactMaterial& material, double depth_m,
                                    double approach_speed_m_s) noexcept;

/// Coulomb friction, regularised: friction * normal force against the slip, in proportion to it
/// below slip_speed_m_s. Realtime: yes. Pre: material.slip_speed_m_s > 0.
[[nodiscard]] Eigen::Vector3d friction_force_N(const ContactMaterial& material,
                                               double normal_force_N,
                                               const Eigen::Vector3d& slip_m_s) noexcept;

/// The whole force on body a, at the point of contact.
///
/// normal: unit, from b to a. relative_velocity_m_s: of a's point of contact seen from b's.
/// Both the simulation's and the 1 kHz force are sums of this law. Realtime: yes.
[[nodiscard]] Eigen::Vector3d contact_force_N(
    const ContactMaterial& material, double depth_m, const Eigen::Vector3d& normal,
    const Eigen::Vector3d& relative_velocity_m_s) noexcept;

}  // namespace stillgrid::collision
