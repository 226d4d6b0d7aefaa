#include "sim_server/contact/field_ways.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "shared/collision/grid_query.hpp"

namespace stillgrid::contact {
namespace {

/// Fine cells that a push within the step may take a field off its way.
constexpr double kMarginCells = 1.0;
/// By how much a field may say more than a distance is: of it, and of a brick where it is coarse.
constexpr double kSlack = 0.05;

Eigen::Vector3d centre_m(const bodies::FieldBody& field) {
  const auto& c = field.field->shape().centre_m;
  return {double{c[0]}, double{c[1]}, double{c[2]}};
}

/// From the frame's origin to the farthest point of the ball that holds the solid.
double farthest_m(const bodies::FieldBody& field) {
  return centre_m(field).norm() + tangent_radius_m(field);
}

const bodies::RigidBody* body_of(const bodies::World& world, const bodies::FieldBody& field) {
  return field.rigid < 0 ? nullptr : &world.rigid_bodies[static_cast<std::size_t>(field.rigid)];
}

/// How far any point may get within the step.
double travel_m(const bodies::World& world, const bodies::FieldBody& field,
                const bodies::RigidBody& body, double step_s) {
  if (!body.free) {
    const auto [from_m, to_m] = bodies::prescribed_range(body, world.time_s, world.time_s + step_s);
    return std::max(from_m.norm(), to_m.norm());
  }
  const double turn_rad = std::min(2.0, step_s * body.angular_velocity_rad_s.norm());
  return step_s * body.velocity_m_s.norm() + step_s * step_s * world.gravity_m_s2.norm() +
         turn_rad * farthest_m(field) + kMarginCells * cell_m(field);
}

void bound(const bodies::FieldBody& field, FieldWay& way) {
  way.ball = collision::bound_sphere(way.start.position_m + way.start.rotation * centre_m(field),
                                     tangent_radius_m(field) + way.travel_m);
}

const collision::ContactMaterial& material_of(const bodies::World& world, int material) {
  return world.materials[static_cast<std::size_t>(material)];
}

void note_start(const FieldTouch& touch, Contact& contact) {
  contact.depth_before_m = touch.depth_m;
  contact.map_scale_before = touch.map_scale;
}

}  // namespace

void FieldWays::take(const bodies::World& world, double step_s) {
  for (std::size_t i = 0; i < ways_.size(); ++i) {
    const bodies::FieldBody& field = world.fields[i];
    FieldWay& way = ways_[i];
    way.start = pose_of(field, world.rigid_bodies);
    const bodies::RigidBody* const body = body_of(world, field);
    way.is_free = body != nullptr && body->free;
    way.moves = body != nullptr &&
                !world.bodies[static_cast<std::size_t>(field.body)].is_sleeping &&
                (body->free || bodies::is_moved(*body));
    way.travel_m = way.moves ? travel_m(world, field, *body, step_s) : 0.0;
    bound(field, way);
  }
}

bool FieldWays::may_meet(const bodies::World& world, std::size_t field, const FieldWay& way,
                         const collision::SweptBound& ball) {
  if (!collision::meet(way.ball, ball)) return false;
  const bodies::FieldBody& own = world.fields[field];
  const auto& [c, bounding_radius_m] = ball;
  const double away_m = gap_m(own, way.start.into({double{c[0]}, double{c[1]}, double{c[2]}}), 0.0);
  return (1.0 - kSlack) * away_m - kSlack * double{own.field->shape().brick_m} <=
         way.travel_m + double{bounding_radius_m};
}

void FieldWays::add_sphere(const bodies::World& world, std::size_t field, const Mover& mover,
                           std::vector<Contact>& contacts) const {
  const bodies::FieldBody& own = world.fields[field];
  const bodies::SphereBinding& sphere = world.spheres[mover.number];
  Contact& contact = contacts.emplace_back();
  contact.a = static_cast<int>(mover.number);
  contact.b = bodies::number_of_field(world, field);
  contact.material = collision::pair_material(material_of(world, sphere.material),
                                              material_of(world, own.material));
  contact.radius_a_m = sphere.radius_m;
  contact.radius_b_m = tangent_radius_m(own);
  note_start(touch_of(own, ways_[field].start, mover.motion.position_m, sphere.radius_m), contact);
}

void FieldWays::add_static(const bodies::World& world, std::size_t field,
                           const collision::VoxelGrid& static_grid, std::vector<std::uint32_t>& met,
                           std::vector<Contact>& contacts) const {
  const bodies::FieldBody& own = world.fields[field];
  find_ascending(static_grid, ways_[field].ball, met);
  for (const std::uint32_t i : met) {
    const bodies::StaticSphere& sphere = world.static_spheres[i];
    if (!bodies::may_collide(world, own.body, sphere.body)) continue;
    if (!may_meet(world, field, collision::bound_sphere(sphere.position_m, sphere.radius_m)))
      continue;
    Contact& contact = contacts.emplace_back();
    contact.a = bodies::number_of_field(world, field);
    contact.other = static_cast<int>(i);
    contact.material = collision::pair_material(material_of(world, own.material),
                                                material_of(world, sphere.material));
    contact.radius_a_m = tangent_radius_m(own);
    contact.radius_b_m = sphere.radius_m;
    contact.position_b_m = sphere.position_m;
    contact.start_b_m = sphere.position_m;
    note_start(touch_of(own, ways_[field].start, sphere.position_m, sphere.radius_m), contact);
  }
}

void FieldWays::add_tool(const bodies::World& world, std::size_t field,
                         const ToolSphereMotion& sphere, const collision::SweptBound& bound,
                         int number, std::vector<Contact>& contacts) const {
  if (!may_meet(world, field, bound)) return;
  const bodies::FieldBody& own = world.fields[field];
  Contact& contact = contacts.emplace_back();
  contact.a = bodies::number_of_field(world, field);
  set_tool(sphere, number, material_of(world, own.material), contact);
  contact.radius_a_m = tangent_radius_m(own);
  note_start(touch_of(own, ways_[field].start, sphere.position_before_m, sphere.radius_m), contact);
}

}  // namespace stillgrid::contact
