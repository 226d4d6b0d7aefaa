#include "sim_server/bodies/kinds/body_in_world.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace stillgrid::bodies {
namespace {

/// A plane is all that has neither spheres nor a motion.
template <class Shape>
constexpr bool kNeverMoves = std::is_same_v<std::remove_cvref_t<Shape>, PlaneBody>;

void add_deformable(World& world, const BodyDescription& body, const SpringDescription& springs,
                    const SpringNet& net, BodyRange& range) {
  range.first_node = static_cast<int>(world.nodes.size());
  range.node_count = static_cast<int>(net.nodes_m.size());
  range.sheet_nodes = net.sheet_nodes;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : net.nodes_m) centre_m += point / range.node_count;
  int index = 0;
  for (const Eigen::Vector3d& point : net.nodes_m) {
    const bool pinned =
        std::binary_search(springs.pinned_nodes.begin(), springs.pinned_nodes.end(), index++);
    const Eigen::Vector3d velocity_m_s =
        body.velocity_m_s + body.angular_velocity_rad_s.cross(point - centre_m);
    world.nodes.push_back({.position_m = point,
                           .velocity_m_s = pinned ? Eigen::Vector3d::Zero() : velocity_m_s,
                           .mass_kg = body.mass_kg / range.node_count,
                           .pinned = pinned});
  }
  range.first_spring = static_cast<int>(world.springs.size());
  for (const SpringNet::Link& link : net.links) {
    if (link.stiffness_N_per_m <= 0.0) continue;
    const auto at = [&](int node) { return net.nodes_m[static_cast<std::size_t>(node)]; };
    world.springs.push_back({range.first_node + link.a, range.first_node + link.b,
                             springs.spring_rest_ratio * (at(link.b) - at(link.a)).norm(),
                             link.stiffness_N_per_m, springs.spring_damping_N_s_per_m});
  }
  range.spring_count = static_cast<int>(world.springs.size()) - range.first_spring;
}

void add_rigid(World& world, const BodyDescription& body, const RigidShape& shape,
               BodyRange& range) {
  range.rigid = static_cast<int>(world.rigid_bodies.size());
  const bool free = body.motion == Motion::kFree;
  world.rigid_bodies.push_back({.position_m = body.position_m,
                                .orientation = body.orientation,
                                .velocity_m_s = body.velocity_m_s,
                                .angular_velocity_rad_s = body.angular_velocity_rad_s,
                                .mass_kg = body.mass_kg,
                                .inertia_kg_m2 = shape.inertia_kg_m2,
                                .bounding_radius_m = shape.bounding_radius_m,
                                .free = free,
                                .prescribed = body.prescribed});
  if (!free) {
    RigidBody& rigid = world.rigid_bodies.back();
    rigid.prescribed.start_m = body.position_m;
    rigid.velocity_m_s = prescribed_state(rigid, 0.0).velocity_m_s;
  }
}

/// The material of a body's spheres: its own if its stiffness is scaled.
int material_of(World& world, const BodyDescription& body) {
  if (body.stiffness_scale == 1.0) return body.material;
  collision::ContactMaterial material = world.materials[static_cast<std::size_t>(body.material)];
  material.stiffness_N_per_m *= body.stiffness_scale;
  material.damping_N_s_per_m *= body.stiffness_scale;
  world.materials.push_back(material);
  return static_cast<int>(world.materials.size()) - 1;
}

/// What moves of a body, but for its spheres.
void add_moving(World& world, const BodyDescription& body, BodyRange& range) {
  std::visit(
      [&](const auto& shape) {
        if constexpr (requires { net_of(shape, body); })
          add_deformable(world, body, shape.springs, net_of(shape, body), range);
        else if constexpr (requires { rigid_shape(shape, body.mass_kg); })
          add_rigid(world, body, rigid_shape(shape, body.mass_kg), range);
        else
          static_assert(kNeverMoves<decltype(shape)>, "a kind has net_of() or rigid_shape()");
      },
      body.shape);
}

void add_spheres(World& world, const BodyDescription& body, int number, int material,
                 BodyRange& range) {
  range.first_sphere = static_cast<int>(world.spheres.size());
  for (SphereBinding& sphere : pack_spheres(body)) {
    sphere.body = number;
    sphere.material = material;
    if (body.motion == Motion::kStatic) {
      (sphere.is_field_point ? world.static_points : world.static_spheres)
          .push_back({sphere.rest_position_m, sphere.radius_m, material, number});
      continue;
    }
    sphere.rigid = range.rigid;
    for (int& node : sphere.nodes) node += range.first_node;
    world.spheres.push_back(sphere);
  }
  range.sphere_count = static_cast<int>(world.spheres.size()) - range.first_sphere;
}

void add_fields(World& world, const BodyDescription& body, int number, int material, int rigid) {
  FieldBody field;
  field.body = number;
  field.material = material;
  field.rigid = rigid;
  const auto add = [&](const auto& distance, const Eigen::Vector3d& position_m,
                       const Eigen::Quaterniond& orientation) {
    field.position_m = position_m;
    field.orientation = orientation;
    if (rigid < 0) {
      field.position_m = body.position_m + body.orientation * position_m;
      field.orientation = body.orientation * orientation;
    }
    field.field = distance;
    world.fields.push_back(field);
  };
  if (const auto distance = field_of(body))
    add(distance, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
  if (const auto* const compound = std::get_if<CompoundBody>(&body.shape))
    for (const SolidShape& shape : compound->shapes)
      if (shape.kind != SolidShape::Kind::kSphere)
        add(field_of(shape), shape.position_m, shape.orientation);
}

}  // namespace

std::vector<SphereBinding> pack_spheres(const BodyDescription& body) {
  std::vector<SphereBinding> spheres = std::visit(
      [&](const auto& shape) -> std::vector<SphereBinding> {
        if constexpr (kNeverMoves<decltype(shape)>)
          return {};
        else
          return spheres_of(shape, body);
      },
      body.shape);
  for (SphereBinding& sphere : spheres) sphere.material = body.material;
  return spheres;
}

SpringNet spring_net_of(const BodyDescription& body) {
  return std::visit(
      [&](const auto& shape) -> SpringNet {
        if constexpr (requires { net_of(shape, body); }) return net_of(shape, body);
        return {};
      },
      body.shape);
}

BodyCounts counts_of(const BodyDescription& body) {
  return std::visit([](const auto& shape) { return counts_of(shape); }, body.shape);
}

void add_body(World& world, const BodyDescription& body) {
  const int number = static_cast<int>(world.bodies.size());
  BodyRange& range = world.bodies.emplace_back();
  range.name = body.name;
  if (const auto* plane = std::get_if<PlaneBody>(&body.shape)) {
    world.planes.push_back(
        {plane->normal, plane->normal.dot(body.position_m), body.material, number});
    return;
  }
  if (body.motion != Motion::kStatic) add_moving(world, body, range);
  const int material = material_of(world, body);
  add_spheres(world, body, number, material, range);
  add_fields(world, body, number, material, range.rigid);
}

std::vector<BodySurface> rest_surfaces(std::span<const BodyDescription> bodies,
                                       const World& world) {
  std::vector<BodySurface> surfaces;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const BodyDescription& body = bodies[i];
    const int number = static_cast<int>(i);
    BodySurface surface = std::visit(
        [&](const auto& shape) -> BodySurface {
          if constexpr (requires { surface_of(shape, body, rest_spheres(world, number)); })
            return surface_of(shape, body, rest_spheres(world, number));
          return {};
        },
        body.shape);
    surface.body = number;
    if (!surface.vertices.empty()) surfaces.push_back(std::move(surface));
  }
  return surfaces;
}

}  // namespace stillgrid::bodies
