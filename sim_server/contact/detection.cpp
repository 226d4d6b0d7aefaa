#include "sim_server/contact/detection.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace stillgrid::contact {
namespace {

/// Squares whose roots are within a float's range, by far.
constexpr double kLarge = 1e60;

/// Edge of the static grid's voxels, over twice its swept bounds' radius, where the scene asks for
/// none.
constexpr float kStaticRatio = 1.5F;

/// A sphere where it is, in a grid's floats.
collision::SweptBound ball_of(const Eigen::Vector3d& centre_m, double radius_m) {
  const Eigen::Vector3f c = centre_m.cast<float>();
  return {{c.x(), c.y(), c.z()}, static_cast<float>(radius_m)};
}

/// Swept bounds of the spheres that never move, as a reader of their published floats would make
/// them.
std::vector<collision::SweptBound> static_bounds(const bodies::World& world) {
  std::vector<collision::SweptBound> swept_bounds;
  for (const bodies::StaticSphere& sphere : world.static_spheres)
    swept_bounds.push_back(collision::bound_sphere(sphere.position_m.cast<float>().cast<double>(),
                                                   static_cast<float>(sphere.radius_m)));
  return swept_bounds;
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

/// 0, 1, ... of all moving spheres.
std::vector<std::uint32_t> all_spheres(const bodies::World& world) {
  std::vector<std::uint32_t> spheres(world.spheres.size());
  std::iota(spheres.begin(), spheres.end(), 0U);
  return spheres;
}

}  // namespace

Detection::Detection(const bodies::World& world, double voxel_ratio)
    : self_collision_(world),
      moving_(world.spheres.size(), static_cast<float>(voxel_ratio),
              groups_of(world, all_spheres(world))),
      static_(0, world.static_spheres.size()),
      motion_(world.spheres.size()) {
  static_.enter(static_bounds(world),
                voxel_ratio > 0.0 ? static_cast<float>(voxel_ratio) : kStaticRatio);
  for (const bodies::SphereBinding& sphere : world.spheres)
    is_free_.push_back(contact::is_free(world, sphere));
  note_sleep(world);
  std::vector<collision::SweptBound> balls;
  for (std::size_t i = 0; i < world.spheres.size(); ++i)
    balls.push_back(ball_of(motion_[i].position_m, world.spheres[i].radius_m));
  moving_.enter(balls);
}

void Detection::note_sleep(const bodies::World& world) {
  moves_.assign(world.spheres.size(), 1);
  move_spheres(world);
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    const bodies::SphereBinding& sphere = world.spheres[i];
    const bool is_sleeping = world.bodies[static_cast<std::size_t>(sphere.body)].is_sleeping;
    moves_[i] = !is_sleeping &&
                (is_free(i) ||
                 bodies::is_moved(world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)]));
  }
}

void Detection::move_spheres(const bodies::World& world) {
  bodies::SphereMotions motion_of(world.nodes, world.rigid_bodies);
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    if (!moves(i)) continue;
    motion_[i] = motion_of(world.spheres[i]);
    // As published: what is beyond a float's range is as lost as what is no number.
    const auto& [position_m, velocity_m_s] = motion_[i];
    if (position_m.squaredNorm() + velocity_m_s.squaredNorm() < kLarge) continue;
    if (!position_m.cast<float>().allFinite() || !velocity_m_s.cast<float>().allFinite())
      refuse(world, i, motion_[i]);
  }
}

}  // namespace stillgrid::contact
