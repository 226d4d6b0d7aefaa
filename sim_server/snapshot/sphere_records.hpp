#pragma once

#include <vector>

#include "proto/scene_segment.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"

namespace stillgrid::snapshot {

/// Returns the published position and velocity of a sphere, in floats.
[[nodiscard]] proto::SphereState state_of(const bodies::SphereMotion& motion) noexcept;

/// Writes radius, material and body of a sphere into its record.
template <class Sphere>
void describe(const Sphere& sphere, proto::SphereRecord& record) noexcept {
  record.radius_m = static_cast<float>(sphere.radius_m);
  record.material = static_cast<std::uint32_t>(sphere.material);
  record.body = static_cast<std::uint32_t>(sphere.body);
}

/// Records of the spheres that never move, in the order of World::static_spheres.
[[nodiscard]] std::vector<proto::SphereRecord> static_records(const bodies::World& world);

}  // namespace stillgrid::snapshot
