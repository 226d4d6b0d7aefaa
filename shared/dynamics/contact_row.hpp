#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/work_sharing.hpp"

namespace stillgrid::dynamics {

/// Contacts in one row. No mover occurs twice in a row of contacts that are solved in turn. Vectors
/// of any width then read and write movers lane by lane.
inline constexpr std::size_t kRowLanes = 16;

using RowFloats = float[kRowLanes];
using RowIndices = std::int32_t[kRowLanes];

/// Velocity of a node or a rigid body as contacts see it.
struct alignas(32) Mover {
  float velocity_m_s[3] = {};
  float inverse_mass_per_kg = 0.0F;  // zero: no impulse moves it
  float spin[3] = {};     // angular velocity in rad/s; of a ball times its radius, in m/s
  float contacts = 0.0F;  // that are solved at once and may push it within the substep
};

/// Inverse inertia of a rigid body in the frame of the world, 1/(kg m^2).
struct alignas(32) InverseInertia {
  float xx = 0, xy = 0, xz = 0, zero = 0, yy = 0, yz = 0, zz = 0, zero_too = 0;
};

/// Position of a collision sphere.
struct alignas(16) SpherePlace {
  float moved_m[3] = {};  // since contacts were listed
  float margin_m = 0.0F;  // how far it may move within a substep
};
struct alignas(16) SphereArm {
  float arm_m[3] = {};  // centre of the rigid body to the sphere's
  float radius_m = 0.0F;
};

/// How an impulse acts on one side of a contact.
enum class SideKind : std::int32_t {  // so that a RowGroup has no padding
  kBall,   // a rigid body that is one sphere: its spin needs neither an arm nor an inertia
  kRigid,  // any other rigid body, also a driven one
  kSoft,   // a weighted sum of nodes
  kPlane,  // the world: never moves
};

/// The nodes of the soft side of a row. Unused ones have weight zero.
struct alignas(64) SoftSide {
  std::int32_t node[4][kRowLanes];
  RowFloats weight[4];
};
/// The arms of the rigid side of a row, from the centre of mass to the point of contact.
struct alignas(64) RigidSide {
  RowFloats arm_m[3];
};

/// All that an iteration over one row reads and writes. Impulses are in N s and act on side a.
struct alignas(64) ContactRow {
  RowIndices mover_a, mover_b;
  RowFloats normal[3];                           // unit, towards a
  RowFloats spring_N_s_per_m, damper_N_s_per_m;  // impulse per sum and per difference of the
                                                 // depths at the start and at the end
  RowFloats inverse_spring, inverse_both;        // solutions of the implicit equations
  RowFloats held_impulse_N_s[3];                 // friction at zero slip at the end of the substep
  RowFloats hold_slope_kg;                       // its change per velocity at the end
  RowFloats normal_mass_per_kg, across_mass_per_kg;  // inverse effective masses
  RowFloats depth_m;  // at the middle of the substep; far below zero where no contact is near
  RowFloats start_m;  // depth at the start of the substep
  RowFloats lever;    // distance of the centres over the sum of the radii
  RowFloats friction, viscous_s_per_m;  // the latter is zero where friction sticks
  RowFloats push_impulse_N_s,
      friction_impulse_N_s[3];  // the impulses of the last substep: normal and friction
};

/// Geometry and material of a row, read once a substep.
struct alignas(64) RowPlace {
  RowIndices sphere_a, sphere_b;  // numbers of rows of spheres; of a plane its number
  RowFloats apart_m[3];           // b to a at the last listing
  RowFloats radii_m;              // their sum
  RowFloats stretch_m[3];         // friction's spring
  RowFloats stiffness_N_per_m, damping_N_s_per_m;
};

/// Whether contacts of these kinds are between balls, or a ball and a plane.
[[nodiscard]] constexpr bool is_of_balls(SideKind a, SideKind b) {
  return a == SideKind::kBall && (b == SideKind::kBall || b == SideKind::kPlane);
}
/// Whether contacts of these kinds may be solved one after another. Those of nodes are not: a
/// sphere moves up to four nodes, which its neighbours move too.
[[nodiscard]] constexpr bool may_be_in_turn(SideKind a, SideKind b) {
  return a != SideKind::kSoft && b != SideKind::kSoft;
}

/// A run of rows whose sides are of the same kinds. Its contacts are solved one after another,
/// which converges faster, or all at once: few bodies of many contacts would leave rows empty.
struct RowGroup {
  SideKind a = SideKind::kBall, b = SideKind::kBall;
  std::size_t first = 0, end = 0;                  // rows
  std::size_t first_side_a = 0, first_side_b = 0;  // into soft_sides or rigid_sides
  std::uint32_t is_in_turn = 0;
  std::uint32_t part = 0;  // see part_of()

  /// Iterations of a substep, in turn forwards and backwards. Two balls have one contact. Those of
  /// a box's face share two bodies: with six iterations in turn an undamped box gains 0.11 % of its
  /// energy in a bounce. One of contacts solved at once leaves up to 0.4 of their error.
  [[nodiscard]] int iterations() const { return is_of_balls(a, b) ? 2 : is_in_turn != 0 ? 8 : 6; }
};
inline constexpr int kMaxIterations = 8;

inline constexpr std::size_t kContactParts = 35;  // numbers that part_of() returns are below it

/// Returns the part of space in which a contact of two balls is solved. Two odd parts have no ball
/// in common, and neither have two even ones, so that threads solve them side by side.
///
/// Odd parts are runs of equally many places. Even parts are runs from the middle of one to the
/// middle of the next, and have the contacts across its border. A contact in neither has part 0.
[[nodiscard]] constexpr std::uint32_t part_of(std::size_t places, std::size_t a, std::size_t b) {
  constexpr std::size_t kLeastPlaces = 4096;
  const std::size_t wide = std::max(kLeastPlaces, places / 16), half = wide / 2;
  if (places <= wide) return 0;
  if (a / wide == b / wide) return static_cast<std::uint32_t>(2 * (a / wide) + 1);
  if ((a + half) / wide == (b + half) / wide)
    return static_cast<std::uint32_t>(2 * ((a + half) / wide) + 2);
  return 0;
}

/// Whether the contacts of a group share no ball with those of the group before it.
[[nodiscard]] constexpr bool is_beside(const RowGroup& before, const RowGroup& group) {
  return before.part != 0 && before.a == group.a && before.b == group.b &&
         before.part % 2 == group.part % 2 && before.part < group.part;
}

/// The listed contacts, in the order in which they are solved.
struct RowList {
  std::vector<ContactRow> rows;
  std::vector<RowPlace> places;
  std::vector<RowGroup> groups;
  std::vector<SoftSide> soft_sides;
  std::vector<RigidSide> rigid_sides;
};

/// Calls visit(group, row) for all rows, by several threads where there are.
template <class Visit>
void each_row(const RowList& list, const WorkSharing& sharing, const Visit& visit) {
  constexpr std::size_t kRowsAPart = 64;  // fewer cost more than they share
  sharing.for_each_chunk(list.rows.size(), kRowsAPart, [&](std::size_t first, std::size_t end) {
    auto group = std::ranges::upper_bound(list.groups, first, {}, &RowGroup::end);
    for (std::size_t row = first; row < end; ++row) {
      while (row >= group->end) ++group;
      visit(*group, row);
    }
  });
}

/// Movers and spheres that rows refer to.
struct ContactBodies {
  std::vector<Mover> movers;          // nodes, then rigid bodies, then one that never moves
  std::vector<Mover> changes;         // sums over contacts that are solved at once, as movers
  std::vector<std::int32_t> changed;  // movers of such contacts that may push within the substep
  std::vector<std::int32_t> in_turn;  // counts of contacts solved in turn but of balls, as movers
  std::vector<InverseInertia> inverse_inertias;  // stored as movers; zero for balls
  std::vector<SpherePlace> places;
  std::vector<SphereArm> arms;
};

/// Whether both sides of a contact are driven bodies.
[[nodiscard]] inline bool is_between_driven(const RowGroup& group, const ContactRow& row,
                                            const ContactBodies& bodies, std::size_t lane) {
  const auto is_driven = [&](std::int32_t mover) {
    return bodies.movers[static_cast<std::size_t>(mover)].inverse_mass_per_kg == 0.0F;
  };
  return group.a == SideKind::kRigid && group.b == SideKind::kRigid &&
         is_driven(row.mover_a[lane]) && is_driven(row.mover_b[lane]);
}

/// Returns the three numbers of a lane.
[[nodiscard]] inline Eigen::Vector3d lane_of(const RowFloats (&columns)[3], std::size_t lane) {
  return {columns[0][lane], columns[1][lane], columns[2][lane]};
}

/// Rounds three numbers to floats.
inline void set_vector(float (&to)[3], const Vector4& v) {
  to[0] = static_cast<float>(v.x);
  to[1] = static_cast<float>(v.y);
  to[2] = static_cast<float>(v.z);
}

}  // namespace stillgrid::dynamics
