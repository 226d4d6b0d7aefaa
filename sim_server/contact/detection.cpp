#include "sim_server/contact/detection.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "shared/collision/grid_query.hpp"

namespace stillgrid::contact {
namespace {

/// Half of a path that only a state that is lost takes, and whose square is still a float's.
constexpr float kLost_m = 1e13F;
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
      motion_(world.spheres.size()),
      paths_(world.spheres.size()),
      fields_(world.fields.size()) {
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
    const Eigen::Vector3d& at_m = motion_[i].position_m;
    if (!moves(i))
      paths_[i] = collision::bound_sweep(at_m, at_m, (1.0 + kMargin) * sphere.radius_m);
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

void Detection::find_contacts(const bodies::World& world, double step_s) {
  step_s_ = step_s;
  bound_sweeps(world, step_s);
  fields_.take(world, step_s);
  contacts_.clear();
  add_pairs(world);
  add_given(world);
  add_fields(world);
}

void Detection::bound_sweeps(const bodies::World& world, double step_s) {
  move_spheres(world);
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    if (!moves(i)) continue;
    paths_[i] = way_bound(world, world.spheres[i], motion_[i], step_s);
    if (!(paths_[i].bounding_radius_m < kLost_m)) refuse(world, i, motion_[i]);
  }
}

void Detection::add_pairs(const bodies::World& world) {
  const auto may = [&](std::uint32_t i, std::uint32_t j) { return may_collide(world, i, j); };
  for (const auto& [i, j] : moving_.find(paths_, may))
    if (moves(i) || moves(j)) add_pair(world, mover(i), mover(j), contacts_);
}

/// Contacts with what is static.
void Detection::add_given(const bodies::World& world) {
  const auto each = [&](auto&& add) {
    for (std::uint32_t i = 0; i < world.spheres.size(); ++i)
      if (is_free(i) && moves(i)) add(mover(i));
  };
  if (!world.static_spheres.empty())
    each([&](const Mover& a) {
      if (!world.spheres[a.number].is_field_point) add_static(world, static_, a, contacts_);
    });
  for (const bodies::StaticPlane& plane : world.planes)
    each([&](const Mover& a) {
      if (may_touch(world, plane, a, step_s_)) add_plane(world, plane, a, contacts_);
    });
}

/// Contacts of fields with spheres, moving and static.
void Detection::add_fields(const bodies::World& world) {
  for (std::size_t field = 0; field < fields_.size(); ++field) {
    const FieldWay& way = fields_[field];
    find_ascending(moving_.grid(), way.ball, met_);
    for (const std::uint32_t i : met_)
      if (world.spheres[i].body != world.fields[field].body && (is_free(i) || way.is_free) &&
          (moves(i) || way.moves) &&
          bodies::may_collide(world, world.spheres[i].body, world.fields[field].body) &&
          fields_.may_meet(world, field, paths_[i]))
        fields_.add_sphere(world, field, mover(i), contacts_);
    if (way.is_free && way.moves && !world.static_spheres.empty())
      fields_.add_static(world, field, static_, met_, contacts_);
  }
}

void Detection::find_tool_contacts(const bodies::World& world,
                                   const std::vector<ToolSphereMotion>& tool) {
  while (!contacts_.empty() && contacts_.back().is_tool) contacts_.pop_back();
  for (std::size_t number = 0; number < tool.size(); ++number) {
    const collision::SweptBound way = bound_of(tool[number]);
    find_ascending(moving_.grid(), way, met_);
    for (const std::uint32_t i : met_)
      if (is_free(i) && !world.spheres[i].is_field_point && collision::meet(paths_[i], way))
        add_tool(world, mover(i), tool[number], static_cast<int>(number), contacts_);
    for (std::size_t field = 0; field < fields_.size(); ++field)
      if (fields_[field].is_free)
        fields_.add_tool(world, field, tool[number], way, static_cast<int>(number), contacts_);
  }
}

}  // namespace stillgrid::contact
