#pragma once

#include <vector>

#include "sim_server/bodies/world.hpp"

namespace stillgrid::contact {

/// Two spheres, or a sphere or a field and something given, that overlap deeply.
struct Overlap {
  int body = 0, other = 0;  // numbers of World::bodies
  bool other_moves = false;
  int plane = -1;        // number in World::planes; -1: the other is no plane
  double depth_m = 0.0;  // more than half of the smaller radius; of a plane, than the radius
};

/// Returns the pairs that overlap deeply in a world. Pairs that may not collide are left out.
[[nodiscard]] std::vector<Overlap> deep_overlaps(const bodies::World& world);

}  // namespace stillgrid::contact
