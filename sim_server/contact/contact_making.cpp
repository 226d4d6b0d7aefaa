#include "sim_server/contact/contact_making.hpp"

#include <algorithm>

#include "shared/collision/grid_query.hpp"
#include "sim_server/contact/pair_search.hpp"

namespace stillgrid::contact {
namespace {

const bodies::RigidBody& rigid_of(const bodies::World& world, const bodies::SphereBinding& sphere) {
  return world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)];
}

const collision::ContactMaterial& material_of(const bodies::World& world, int material) {
  return world.materials[static_cast<std::size_t>(material)];
}
const collision::ContactMaterial& material_of(const bodies::World& world, const Mover& mover) {
  return material_of(world, world.spheres[mover.number].material);
}

/// A contact of a moving sphere, yet without what it touches.
Contact& add_contact(std::vector<Contact>& contacts, const bodies::World& world,
                     const Mover& mover) {
  Contact& contact = contacts.emplace_back();
  contact.a = static_cast<int>(mover.number);
  contact.radius_a_m = world.spheres[mover.number].radius_m;
  return contact;
}

/// How far turning takes a point of a body off the straight way that it is on, at most.
double turned_aside_m(const bodies::RigidBody& body, const Eigen::Vector3d& point_m,
                      double step_s) {
  const double turn_rad = step_s * body.angular_velocity_rad_s.norm();
  if (turn_rad == 0.0) return 0.0;
  const double arm_m = (point_m - body.position_m).norm();
  return arm_m * std::min(0.5 * turn_rad * turn_rad, 2.0 + turn_rad);
}

}  // namespace

double with_margin_m(const bodies::World& world, const bodies::SphereBinding& sphere) {
  const double own_m = (1.0 + kMargin) * sphere.radius_m;
  if (!sphere.is_field_point) return own_m;
  return std::max(own_m,
                  sphere.radius_m + kPointMargin * rigid_of(world, sphere).bounding_radius_m);
}

bool is_free(const bodies::World& world, const bodies::SphereBinding& sphere) {
  return sphere.rigid < 0 || rigid_of(world, sphere).free;
}

collision::SweptBound way_bound(const bodies::World& world, const bodies::SphereBinding& sphere,
                                const bodies::SphereMotion& now, double step_s) {
  double radius_m = with_margin_m(world, sphere);
  if (!is_free(world, sphere)) {
    const bodies::RigidBody& body = rigid_of(world, sphere);
    const auto [from_m, to_m] = bodies::prescribed_range(body, world.time_s, world.time_s + step_s);
    return collision::bound_sweep(now.position_m + from_m, now.position_m + to_m, radius_m);
  }
  if (sphere.rigid >= 0)
    radius_m += turned_aside_m(rigid_of(world, sphere), now.position_m, step_s);
  // Where it is, where it would be without and with its fall: every shorter step ends between them.
  const Eigen::Vector3d straight_m = now.position_m + step_s * now.velocity_m_s;
  const Eigen::Vector3d fall_m = step_s * step_s * world.gravity_m_s2;
  return collision::bound_sweep(now.position_m, straight_m, straight_m + fall_m, radius_m);
}

std::vector<std::uint32_t> groups_of(const bodies::World& world,
                                     std::span<const std::uint32_t> spheres) {
  constexpr std::uint32_t kPrescribed = 0xffff'fffe, kPoints = 0xffff'fffd;
  std::vector<std::uint32_t> groups;
  groups.reserve(spheres.size());
  for (const std::uint32_t number : spheres) {
    const bodies::SphereBinding& sphere = world.spheres[number];
    const auto own = sphere.rigid < 0 ? kNoGroup : static_cast<std::uint32_t>(sphere.rigid);
    groups.push_back(sphere.is_field_point ? kPoints : is_free(world, sphere) ? own : kPrescribed);
  }
  return groups;
}

void add_pair(const bodies::World& world, const Mover& a, const Mover& b,
              std::vector<Contact>& contacts) {
  Contact& contact = add_contact(contacts, world, a);
  contact.b = static_cast<int>(b.number);
  contact.material = collision::pair_material(material_of(world, a), material_of(world, b));
  contact.radius_b_m = world.spheres[b.number].radius_m;
  contact.depth_before_m =
      contact.radius_a_m + contact.radius_b_m - (a.motion.position_m - b.motion.position_m).norm();
}

void add_static(const bodies::World& world, const collision::VoxelGrid& static_grid,
                const Mover& mover, std::vector<Contact>& contacts) {
  collision::for_each_candidate(
      static_grid.view(), mover.way, collision::kAllVisits, [&](std::uint32_t j) {
        const bodies::StaticSphere& b = world.static_spheres[j];
        if (!bodies::may_collide(world, world.spheres[mover.number].body, b.body)) return;
        Contact& contact = add_contact(contacts, world, mover);
        contact.other = static_cast<int>(j);
        contact.material =
            collision::pair_material(material_of(world, mover), material_of(world, b.material));
        contact.radius_b_m = b.radius_m;
        contact.position_b_m = b.position_m;
        contact.start_b_m = b.position_m;
        contact.depth_before_m =
            contact.radius_a_m + b.radius_m - (mover.motion.position_m - b.position_m).norm();
      });
}

void add_plane(const bodies::World& world, const bodies::StaticPlane& plane, const Mover& mover,
               std::vector<Contact>& contacts) {
  Contact& contact = add_contact(contacts, world, mover);
  contact.other = static_cast<int>(&plane - world.planes.data());
  contact.material =
      collision::pair_material(material_of(world, mover), material_of(world, plane.material));
  contact.is_plane = true;
  contact.plane_normal = plane.normal;
  contact.plane_offset_m = plane.offset_m;
  contact.depth_before_m =
      contact.radius_a_m - (plane.normal.dot(mover.motion.position_m) - plane.offset_m);
}

bool may_touch(const bodies::World& world, const bodies::StaticPlane& plane, const Mover& mover,
               double step_s) {
  const double height_m = plane.normal.dot(mover.motion.position_m) - plane.offset_m;
  const double move_m = step_s * plane.normal.dot(mover.motion.velocity_m_s);
  const double fall_m = step_s * step_s * plane.normal.dot(world.gravity_m_s2);
  const bodies::SphereBinding& sphere = world.spheres[mover.number];
  if (!bodies::may_collide(world, sphere.body, plane.body)) return false;
  double within_m = with_margin_m(world, sphere);
  if (height_m + std::min({0.0, move_m, move_m + fall_m}) <= within_m) return true;
  if (sphere.rigid < 0) return false;
  within_m += turned_aside_m(rigid_of(world, sphere), mover.motion.position_m, step_s);
  return height_m + std::min({0.0, move_m, move_m + fall_m}) <= within_m;
}

void set_tool(const ToolSphereMotion& sphere, int number, const collision::ContactMaterial& touched,
              Contact& contact) {
  contact.other = number;
  contact.material = collision::tool_material(touched, sphere.slip_speed_m_s);
  contact.radius_b_m = sphere.radius_m;
  contact.position_b_m = sphere.position_m;
  contact.start_b_m = sphere.position_before_m;
  contact.velocity_b_m_s = sphere.velocity_m_s;
  contact.spin_b_rad_s = sphere.spin_rad_s;
  contact.is_tool = true;
  contact.hand = sphere.hand;
}

void add_tool(const bodies::World& world, const Mover& mover, const ToolSphereMotion& sphere,
              int number, std::vector<Contact>& contacts) {
  Contact& contact = add_contact(contacts, world, mover);
  set_tool(sphere, number, material_of(world, mover), contact);
  contact.depth_before_m = contact.radius_a_m + sphere.radius_m -
                           (mover.motion.position_m - sphere.position_before_m).norm();
}

void find_ascending(const collision::VoxelGrid& grid, const collision::SweptBound& way,
                    std::vector<std::uint32_t>& spheres) {
  spheres.clear();
  collision::for_each_candidate(grid.view(), way, collision::kAllVisits,
                                [&](std::uint32_t i) { spheres.push_back(i); });
  std::sort(spheres.begin(), spheres.end());
}

}  // namespace stillgrid::contact
