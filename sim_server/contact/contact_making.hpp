#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/collision/voxel_grid.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"

namespace stillgrid::contact {

/// A sphere of the tool in the scene, as sampled for this step and as it was a step before.
struct ToolSphereMotion {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
  Eigen::Vector3d position_before_m;
  double radius_m;
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
  double slip_speed_m_s = 0.05;  // least, of a contact with it
  int hand = 0;                  // whose tool it is
};

/// Slack round a sphere's way, of its radius: what a push within the step may add.
inline constexpr double kMargin = 0.1;

/// The same round a point of a field's body, whose own radius is small: of the body's bounding
/// radius.
inline constexpr double kPointMargin = 0.02;
/// A sphere's radius with this slack.
[[nodiscard]] double with_margin_m(const bodies::World& world, const bodies::SphereBinding& sphere);

/// Whether it is not prescribed where a sphere goes.
[[nodiscard]] bool is_free(const bodies::World& world, const bodies::SphereBinding& sphere);

/// The ball that holds a sphere, and its slack, wherever it may be within step_s. Prescribed:
/// the way that its law leads. Free: straight on by its velocity, with and without its fall, and
/// what turning with its body takes it off that.
[[nodiscard]] collision::SweptBound way_bound(const bodies::World& world,
                                              const bodies::SphereBinding& sphere,
                                              const bodies::SphereMotion& now, double step_s);

/// Whether a sphere that has this way goes farther than its radius.
[[nodiscard]] inline bool is_fast(const collision::SweptBound& way, double radius_m) {
  return way.bounding_radius_m > (0.5 + 1.0 + kMargin) * radius_m;  // half of its way, and itself
}

/// Pairs and contacts that a step may list of so many spheres without a thought of memory.
[[nodiscard]] inline std::size_t most_pairs(std::size_t spheres) {
  return 64 * spheres + 20'000;
}
[[nodiscard]] inline std::size_t most_contacts(std::size_t spheres) {
  return 16 * spheres + 20'000;
}

/// Groups for MovingSpheres: spheres of a rigid body never touch each other, nor do those of all
/// that is prescribed, nor points of fields. spheres: numbers of World::spheres.
[[nodiscard]] std::vector<std::uint32_t> groups_of(const bodies::World& world,
                                                   std::span<const std::uint32_t> spheres);

/// A moving sphere, where it is and the ball that holds its way.
struct Mover {
  std::uint32_t number;  // of World::spheres
  const bodies::SphereMotion& motion;
  const collision::SweptBound& way;
};

// What a sphere may touch within a step, appended to `contacts`.

/// Two moving spheres.
void add_pair(const bodies::World& world, const Mover& a, const Mover& b,
              std::vector<Contact>& contacts);
/// Static spheres that its way meets, in the order of their grid.
void add_static(const bodies::World& world, const collision::VoxelGrid& static_grid,
                const Mover& mover, std::vector<Contact>& contacts);
/// A plane.
void add_plane(const bodies::World& world, const bodies::StaticPlane& plane, const Mover& mover,
               std::vector<Contact>& contacts);
/// Whether a free sphere may come within its margin of a plane by then.
[[nodiscard]] bool may_touch(const bodies::World& world, const bodies::StaticPlane& plane,
                             const Mover& mover, double step_s);
/// The ball that holds a sphere of the tool on its way.
[[nodiscard]] inline collision::SweptBound bound_of(const ToolSphereMotion& sphere) {
  return collision::bound_sweep(sphere.position_before_m, sphere.position_m, sphere.radius_m);
}
/// The tool's side of a contact with what is of this material.
void set_tool(const ToolSphereMotion& sphere, int number, const collision::ContactMaterial& touched,
              Contact& contact);
/// A sphere of the tool, which is number `number` of it.
void add_tool(const bodies::World& world, const Mover& mover, const ToolSphereMotion& sphere,
              int number, std::vector<Contact>& contacts);

/// The spheres of a grid whose bounds meet `way`, ascending: however the grid is shaped.
void find_ascending(const collision::VoxelGrid& grid, const collision::SweptBound& way,
                    std::vector<std::uint32_t>& spheres);

}  // namespace stillgrid::contact
