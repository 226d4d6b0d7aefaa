#pragma once

#include <Eigen/Core>
#include <span>

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/contact/contact.hpp"

namespace stillgrid::contact {

/// The straight path of one sphere's centre, seen from the other's, over a step.
struct RelativePath {
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_m = Eigen::Vector3d::Zero();
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

/// The same over all contacts: the least share, with every moving sphere on a straight path from
/// its place at the step's start to that at its end. A plane cannot be crossed: below it is solid.
/// Pre: start and end are of every sphere of the world.
[[nodiscard]] double share_before_crossings(std::span<const Contact> contacts,
                                            std::span<const bodies::SphereMotion> start,
                                            std::span<const bodies::SphereMotion> end) noexcept;

}  // namespace stillgrid::contact
