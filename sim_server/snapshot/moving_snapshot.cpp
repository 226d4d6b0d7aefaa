#include "sim_server/snapshot/moving_snapshot.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "shared/collision/sphere_history.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/snapshot/sphere_records.hpp"

namespace stillgrid::snapshot {
namespace {

Eigen::Map<const Eigen::Vector3f> vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data());
}

/// Its place among the spheres of its body tells a user more than its number in the scene.
[[noreturn]] void refuse(const bodies::World& world, std::size_t sphere,
                         const bodies::SphereMotion& motion) {
  const int body = world.spheres[sphere].body;
  std::size_t first = sphere;
  while (first > 0 && world.spheres[first - 1].body == body) --first;
  const Eigen::Vector3d& p = motion.position_m;
  throw std::domain_error("body '" + world.bodies[static_cast<std::size_t>(body)].name +
                          "': sphere " + std::to_string(sphere - first) + ": position " +
                          std::to_string(p.x()) + ", " + std::to_string(p.y()) + ", " +
                          std::to_string(p.z()) + " m after " + std::to_string(world.time_s) +
                          " s: expected finite numbers");
}

}  // namespace

MovingSnapshot::MovingSnapshot(const bodies::World& world, double voxel_ratio)
    : spheres_(world.spheres.size(), static_cast<float>(voxel_ratio)),
      states_(world.spheres.size()),
      bounds_(world.spheres.size()) {
  const auto records = spheres_.grid().records();
  for (std::size_t i = 0; i < records.size(); ++i) {
    describe(world.spheres[i], records[i]);
    records[i].crushing_force_N = static_cast<float>(world.spheres[i].crushing_force_N);
    if (world.spheres[i].is_field_point) records[i].material = proto::kFieldPoint;
  }
  show(world);
}

void MovingSnapshot::show(const bodies::World& world) {
  bodies::SphereMotions motion_of(world.nodes, world.rigid_bodies);
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const bodies::SphereMotion motion = motion_of(world.spheres[i]);
    states_[i] = state_of(motion);
    // What is beyond a float's range is as lost as what is no number.
    if (!vector(states_[i].position_m).allFinite() || !vector(states_[i].velocity_m_s).allFinite())
      refuse(world, i, motion);
  }
  show(states_);
}

void MovingSnapshot::show(std::span<const proto::SphereState> states) {
  collision::VoxelGrid& grid = spheres_.grid();
  grid.push_snapshot(states);
  const auto records = grid.records();
  const bool is_entered = spheres_.entered_count() > 0;
  for (std::size_t i = 0; i < states.size() && is_entered; ++i) {
    const collision::SweptBound& bound = grid.swept_bound(i);
    const float away_m = (vector(records[i].newest.position_m) - vector(bound.centre_m)).norm() +
                         records[i].radius_m;
    const float needed_m = away_m * (1.0F + contact::kBoundSlack);
    if (!(needed_m <= bound.bounding_radius_m)) grid.grow(i, needed_m);
  }
  if (is_entered && !spheres_.is_outgrown()) return;
  for (std::size_t i = 0; i < states.size(); ++i) bounds_[i] = collision::bound_history(records[i]);
  spheres_.enter(bounds_);
}

}  // namespace stillgrid::snapshot
