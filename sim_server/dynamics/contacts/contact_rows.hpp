#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "sim_server/dynamics/contacts/substep_law.hpp"

namespace stillgrid::dynamics {

/// How a point of contact moves, or what pushes it: a vector and, of a rigid body, its moment.
struct alignas(64) ContactPoint {
  std::array<double, 4> linear{}, angular{};
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
/// Plain arithmetic in one order: the same bytes on every processor.
struct alignas(64) ContactRows {
  static constexpr std::size_t kLanes = 8;
  using Lane = std::array<double, kLanes>;
  using Vector = std::array<Lane, 3>;

  // What a substep does not change. Sides are indices of points, of which 0 never moves.
  std::array<int, kLanes> a{}, b{};
  Vector normal{}, arm_a_m{}, arm_b_m{};
  Vector given_m_s{};                       // velocity of b, or of -a, that no point has
  Lane depth_m{}, start_m{};                // in the middle and at the start
  Lane spring_N_per_m{}, damper_N_per_m{};  // k, c / h
  Lane friction{};
  // What would hold is from + by (velocity across); it yields at friction times normal force, and
  // of the tool in proportion to it: least_m_s is the slip speed, of others negative.
  Vector from{};
  Lane by{}, least_m_s{};
  // What a change of the end velocity asks for, while it sticks.
  Lane normal_slope_kg{}, across_slope_kg{};

  // At the velocities seen last; bounds: slopes that responses count on.
  Vector impulse_N_s{};
  Lane spring_N{}, damper_N{}, held{};
  Lane normal_bound_kg{}, across_bound_kg{};

  /// The contact takes that lane. given: velocity of b without a point, less that of a.
  void set(std::size_t lane, const SubstepContact& contact, const Eigen::Vector3d& given,
           double substep_s);
  [[nodiscard]] Eigen::Vector3d impulse_of(std::size_t lane) const {
    return {impulse_N_s[0][lane], impulse_N_s[1][lane], impulse_N_s[2][lane]};
  }
  /// Impulses by the points' velocities, added to both sides'. Whether none may change by more than
  /// its bounds say; those that may have new bounds.
  [[nodiscard]] bool evaluate(std::span<const ContactPoint> velocities,
                              std::span<ContactPoint> impulses, double substep_s);

 private:
  void find_impulses(const Vector& velocity_m_s, double substep_s);
  [[nodiscard]] bool widen_bounds();
};

}  // namespace stillgrid::dynamics
