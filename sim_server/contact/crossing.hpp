#pragma once

#include <Eigen/Core>
#include <span>

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"

namespace stillgrid::contact {

/// The straight path of one sphere's centre, seen from the other's, over a step.
struct RelativePath {
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_m = Eigen::Vector3d::Zero();
};

/// The ways of all moving spheres and fields over a part of a step: straight and turning evenly,
/// but for those of prescribed bodies that swing, which are known.
struct Ways {
  std::span<const bodies::SphereMotion> start, end;  // of every sphere
  const bodies::World* world = nullptr;  // at the start; null: all is straight, there are no fields
  double duration_s = 0.0;
  std::span<const bodies::RigidBody> end_bodies = {};  // as World::rigid_bodies; or no fields
};

/// How much of the path a step may cover, in (0, 1], so that its end still tells that the spheres
/// met: 1, unless they pass the point of least distance within the step and either overlap at
/// neither end, or come deeper than half of the smaller radius on the way. Then it leads to where
/// they have come that deep, or nearest.
///
/// A step looks at its end only, and would miss the first and take the second for a meeting on the
/// far side (docs/algorithms/fast_bodies.md). An overlap of less than a hundredth of the smaller
/// radius is no meeting.
/// Realtime: never allocates, locks or throws. Pre: radii > 0.
[[nodiscard]] double share_before_crossing(const RelativePath& path, double radius_a_m,
                                           double radius_b_m) noexcept;
/// The same of a way that turns: chords between these corners, even shares of it each. Pre: two
/// corners at least.
[[nodiscard]] double share_before_crossing(std::span<const Eigen::Vector3d> corners_m,
                                           double radius_a_m, double radius_b_m) noexcept;

/// The same over all contacts: the least share. A plane cannot be crossed: below it is solid. So is
/// a field inside: there only a way counts that comes to where the solid pushes on, out of its
/// other side.
[[nodiscard]] double share_before_crossings(std::span<const Contact> contacts,
                                            const Ways& ways) noexcept;

/// Whether the two sides of a contact overlap anywhere on their ways; of a plane: at the end.
/// Pre: ways of fields are told where the contact is of one.
[[nodiscard]] bool meet(const Contact& contact, const Ways& ways) noexcept;

}  // namespace stillgrid::contact
