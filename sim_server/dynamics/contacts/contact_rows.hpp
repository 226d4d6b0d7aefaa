#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "shared/collision/contact_law.hpp"
#include "sim_server/dynamics/contacts/contact_list.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"

namespace stillgrid::dynamics {

/// How a point of contact moves, or what pushes it: a vector and, of a rigid body, its moment.
struct alignas(64) ContactPoint {
  PackedVector linear, angular;
};

/// What a touch pushes its first side by, and its second against: an impulse and its moments.
struct alignas(32) ContactPush {
  PackedVector linear, moment_a, moment_b;
};

/// Contacts of a substep, eight to a block, each ready for the impulse at any end velocity: the
/// mean of the contact law's force over the straight way from the substep's start to its end, times
/// the substep.
///
/// The spring's mean is (U(end) - U(start)) / way with U = k depth^2 / 2 where depth > 0: the work
/// of the impulse is the change of that energy, exactly, also where the contact comes or goes. The
/// approach damper acts over the part of the way in which the spheres overlap. At rest the force is
/// k depth. Friction sticks by contact::sticking_force().
///
/// A lane that no contact took pushes nothing. Plain arithmetic in one order, with vector
/// instructions: the same bytes on every processor.
struct alignas(64) ContactRows {
  static constexpr std::size_t kLanes = 8;
  using Lane = std::array<double, kLanes>;
  using Vector = std::array<Lane, 3>;

  // What a pair is. Points: of which 0 never moves; spheres: in ContactList, b -1: given.
  std::array<int, kLanes> a{}, b{}, sphere_a{}, sphere_b{};
  Lane turns_a{}, turns_b{};                  // 1: the point's angular velocity counts; or 0
  Lane distance_m = filled(1.0), radius_m{};  // of both; of a
  Lane is_plane{};                            // 1: the other is the plane at other_m, across normal
  Lane stiffness_N_per_m{}, damping_N_s_per_m{}, friction{};
  Lane slip_m_s{};  // of the tool, up to which friction is viscous; or -1
  Lane weights{};   // sums of what both sides' movers weigh
  // Where it is given: where the other is in the substep's middle; how both sides move that no
  // point has, of b less that of a: across the normal, along it, and b's spin.
  std::array<PackedVector, kLanes> other_m{};
  Vector given_across_m_s{}, given_along_m_s{}, given_spin_rad_s{};

  // What lasts from substep to substep.
  Vector stretch_m{}, normal{};

  // What a substep does not change.
  Vector arm_a_m{}, arm_b_m{}, given_m_s{};
  Vector begin_m_s{};         // the points' velocities at the substep's start
  Lane depth_m{}, start_m{};  // in the middle and at the start
  Lane held_J{};              // by what sticks, at the start
  // What would hold is from + by (velocity across); it yields at friction times normal force, and
  // of the tool in proportion to it.
  Vector from{};
  Lane by{};
  // What a change of the end velocity asks for, while it sticks.
  Lane normal_slope_kg{}, across_slope_kg{};

  // At the velocities seen last; bounds: slopes that responses count on.
  Vector impulse_N_s{};
  Lane spring_N{}, damper_N{};
  Lane normal_bound_kg{}, across_bound_kg{}, is_widened{};  // 1: the bounds have just grown

  [[nodiscard]] static Lane filled(double value) {
    Lane lane;
    lane.fill(value);
    return lane;
  }
  void set_material(std::size_t lane, const collision::ContactMaterial& material, bool is_viscous);
  static void set(Vector& vector, std::size_t lane, const Eigen::Vector3d& value) {
    for (std::size_t i = 0; i < 3; ++i) vector[i][lane] = value[static_cast<Eigen::Index>(i)];
  }
  [[nodiscard]] static Eigen::Vector3d get(const Vector& vector, std::size_t lane) {
    return {vector[0][lane], vector[1][lane], vector[2][lane]};
  }
};

/// What contacts did in a substep, lane by lane, J.
struct alignas(64) RowFlow {
  ContactRows::Lane damping_J{}, friction_J{}, unsolved_J{}, given_J{}, spring_change_J{};
  bool struck = false;
};

/// Takes contacts to the middle of a substep: its spheres are there, its points move as at its
/// start. What sticks turns along.
void place_rows(std::span<ContactRows> rows, std::span<const ContactSphere> spheres,
                std::span<const ContactPoint> velocities, double substep_s);

/// Impulses by the points' end velocities, a push for each lane. Whether none may change by more
/// than its bounds say; those that may have new bounds.
[[nodiscard]] bool evaluate_rows(std::span<ContactRows> rows,
                                 std::span<const ContactPoint> velocities,
                                 std::span<ContactPush> pushes, double substep_s);

/// Ends a substep at the end velocities that its last impulses made: adds what contacts did on the
/// way that it really takes, and stretches what sticks on.
void end_rows(std::span<ContactRows> rows, std::span<const ContactPoint> velocities,
              double substep_s, RowFlow& flow);

}  // namespace stillgrid::dynamics
