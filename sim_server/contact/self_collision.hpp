#pragma once

#include <utility>
#include <vector>

#include "sim_server/bodies/world.hpp"

namespace stillgrid::contact {

/// Which spheres of one body may collide with each other.
///
/// On a rigid body none. On a deformable one all but those that are neighbours in it, for these
/// overlap at rest, or come to as soon as it is pressed or bent, and would burst it:
///   - by its rest shape: the gap between them at rest is at most half of the smaller radius;
///   - by its springs: they hang on a node in common, or on two that a spring joins.
class SelfCollision {
 public:
  /// Notes which nodes the springs of the world join.
  explicit SelfCollision(const bodies::World& world);

  /// Whether two spheres of the world may collide; true for different bodies.
  /// Realtime: constant time, never allocates, locks or throws.
  [[nodiscard]] bool may_collide(const bodies::SphereBinding& a,
                                 const bodies::SphereBinding& b) const noexcept {
    if (a.body != b.body) return true;  // but for joints: bodies::may_collide()
    return a.rigid < 0 && are_apart_at_rest(a, b) && !are_joined(a, b);
  }

  /// Pairs of spheres of deformable bodies that may not collide, smaller first, sorted.
  [[nodiscard]] std::vector<std::pair<int, int>> apart_spheres(const bodies::World& world) const;

 private:
  [[nodiscard]] static bool are_apart_at_rest(const bodies::SphereBinding& a,
                                              const bodies::SphereBinding& b) noexcept;
  [[nodiscard]] bool are_joined(const bodies::SphereBinding& a,
                                const bodies::SphereBinding& b) const noexcept;

  std::vector<std::size_t> first_neighbour_;  // of each node, and one more
  std::vector<int> neighbours_;               // ascending within a node; the node itself too
};

}  // namespace stillgrid::contact
