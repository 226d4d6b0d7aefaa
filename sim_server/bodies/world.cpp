#include "sim_server/bodies/world.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_server/bodies/sphere_packing.hpp"

namespace stillgrid {
namespace {

void connect(World& world, const BodyDescription& body, int a, int b, double stiffness_N_m) {
  if (stiffness_N_m <= 0.0) return;
  const auto at = [&](int node) { return world.nodes[static_cast<std::size_t>(node)].position_m; };
  world.springs.push_back({a, b, (at(b) - at(a)).norm(), stiffness_N_m, body.spring_damping_N_s_m});
}

/// The nodes of a deformable body in its rest shape.
std::vector<Eigen::Vector3d> rest_nodes(const BodyDescription& body) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& node_m : body.lattice.nodes_m)
    points.emplace_back(body.position_m + body.orientation * node_m);
  if (!points.empty()) return points;
  const auto fraction = [](int i, int n) { return n > 1 ? double(i) / double(n - 1) : 0.0; };
  for (int y = 0; y < body.nodes.y(); ++y)
    for (int x = 0; x < body.nodes.x(); ++x) {
      const double u = fraction(x, body.nodes.x()), v = fraction(y, body.nodes.y());
      if (body.kind == BodyKind::kThread) {
        points.emplace_back(body.from_m + u * (body.to_m - body.from_m));
      } else {
        const Eigen::Vector3d local((u - 0.5) * body.size_m.x(), (v - 0.5) * body.size_m.y(), 0.0);
        points.emplace_back(body.position_m + body.orientation * local);
      }
    }
  return points;
}

/// Structural springs join neighbours, shear springs diagonals, bend springs every second node.
void add_springs(World& world, const BodyDescription& body, int first) {
  const int nx = body.nodes.x(), ny = body.nodes.y();
  const auto join = [&](int x, int y, int dx, int dy, double stiffness_N_m) {
    if (x + dx < 0 || x + dx >= nx || y + dy >= ny) return;
    connect(world, body, first + x + nx * y, first + x + dx + nx * (y + dy), stiffness_N_m);
  };
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x) {
      join(x, y, 1, 0, body.structural_stiffness_N_m);
      join(x, y, 0, 1, body.structural_stiffness_N_m);
      join(x, y, 1, 1, body.shear_stiffness_N_m);
      join(x, y, -1, 1, body.shear_stiffness_N_m);
      join(x, y, 2, 0, body.bend_stiffness_N_m);
      join(x, y, 0, 2, body.bend_stiffness_N_m);
    }
}

void add_lattice_springs(World& world, const BodyDescription& body, int first) {
  for (const LatticeSpring& spring : lattice_springs(body.lattice)) {
    const double stiffness_N_m = spring.link == LatticeLink::kStructural
                                     ? body.structural_stiffness_N_m
                                 : spring.link == LatticeLink::kShear ? body.shear_stiffness_N_m
                                                                      : body.bend_stiffness_N_m;
    connect(world, body, first + spring.a, first + spring.b, stiffness_N_m);
  }
}

void add_deformable(World& world, const BodyDescription& body, BodyRange& range) {
  const std::vector<Eigen::Vector3d> points_m = rest_nodes(body);
  range.first_node = static_cast<int>(world.nodes.size());
  range.node_count = static_cast<int>(points_m.size());
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points_m) centre_m += point / range.node_count;
  int index = 0;
  for (const Eigen::Vector3d& point : points_m) {
    const bool pinned =
        std::binary_search(body.pinned_nodes.begin(), body.pinned_nodes.end(), index++);
    const Eigen::Vector3d velocity_m_s =
        body.velocity_m_s + body.angular_velocity_rad_s.cross(point - centre_m);
    world.nodes.push_back({.position_m = point,
                           .velocity_m_s = pinned ? Eigen::Vector3d::Zero() : velocity_m_s,
                           .mass_kg = body.mass_kg / range.node_count,
                           .pinned = pinned});
  }
  range.first_spring = static_cast<int>(world.springs.size());
  if (body.lattice.nodes_m.empty())
    add_springs(world, body, range.first_node);
  else
    add_lattice_springs(world, body, range.first_node);
  range.spring_count = static_cast<int>(world.springs.size()) - range.first_spring;
  if (body.kind == BodyKind::kSheet) range.sheet_nodes = body.nodes.head<2>();
}

Eigen::Vector3d inertia_kg_m2(const BodyDescription& body) {
  if (body.kind == BodyKind::kMesh) return body.mass_kg * body.inertia_per_kg_m2;
  if (body.kind == BodyKind::kSphere)
    return Eigen::Vector3d::Constant(0.4 * body.mass_kg * body.radius_m * body.radius_m);
  const Eigen::Array3d squared_m2 = body.size_m.array().square();
  return (body.mass_kg / 12.0 * (squared_m2.sum() - squared_m2)).matrix();
}

/// Distance of a rigid body's farthest point from its centre.
double reach_m(const BodyDescription& body) {
  if (body.kind == BodyKind::kSphere) return body.radius_m;
  if (body.kind == BodyKind::kRigidBox) return 0.5 * body.size_m.norm();
  double farthest_m = 0.0;
  for (const Ball& ball : body.balls)
    farthest_m = std::max(farthest_m, ball.centre_m.norm() + ball.radius_m);
  return farthest_m;
}

void add_rigid(World& world, const BodyDescription& body, BodyRange& range) {
  range.rigid = static_cast<int>(world.rigid_bodies.size());
  const bool free = body.motion == Motion::kFree;
  world.rigid_bodies.push_back({.position_m = body.position_m,
                                .orientation = body.orientation,
                                .velocity_m_s = body.velocity_m_s,
                                .angular_velocity_rad_s = body.angular_velocity_rad_s,
                                .mass_kg = body.mass_kg,
                                .inertia_kg_m2 = inertia_kg_m2(body),
                                .reach_m = reach_m(body),
                                .free = free,
                                .start_m = body.position_m,
                                .prescribed = body.prescribed});
  if (!free) {
    RigidBody& rigid = world.rigid_bodies.back();
    rigid.velocity_m_s = prescribed_state(rigid, 0.0).velocity_m_s;
  }
}

/// The material of a body's spheres: its own if its stiffness is scaled.
int material_of(World& world, const BodyDescription& body) {
  if (body.stiffness_scale == 1.0) return body.material;
  ContactMaterial material = world.materials[static_cast<std::size_t>(body.material)];
  material.stiffness_N_m *= body.stiffness_scale;
  material.damping_N_s_m *= body.stiffness_scale;
  world.materials.push_back(material);
  return static_cast<int>(world.materials.size()) - 1;
}

void add_body(World& world, const BodyDescription& body, int number) {
  BodyRange& range = world.bodies.emplace_back();
  range.name = body.name;
  if (body.kind == BodyKind::kPlane) {
    world.planes.push_back({body.normal, body.normal.dot(body.position_m), body.material, number});
    return;
  }
  const int material = material_of(world, body);
  if (body.motion != Motion::kStatic) {
    if (is_deformable(body))
      add_deformable(world, body, range);
    else
      add_rigid(world, body, range);
  }
  range.first_sphere = static_cast<int>(world.spheres.size());
  for (SphereBinding& sphere : pack_spheres(body)) {
    sphere.body = number;
    sphere.material = material;
    if (body.motion == Motion::kStatic) {
      world.still_spheres.push_back({sphere.rest_position_m, sphere.radius_m, material, number});
      continue;
    }
    sphere.rigid = range.rigid;
    for (int& node : sphere.nodes) node += range.first_node;
    world.spheres.push_back(sphere);
  }
  range.sphere_count = static_cast<int>(world.spheres.size()) - range.first_sphere;
}

}  // namespace

World build_world(const SceneDescription& scene) {
  World world;
  world.gravity_m_s2 = scene.gravity_m_s2;
  world.tool_slip_speed_m_s = scene.tool_slip_speed_m_s;
  for (const MaterialDescription& material : scene.materials)
    world.materials.push_back({material.contact_stiffness_N_m, material.contact_damping_N_s_m,
                               material.friction, material.slip_speed_m_s});
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    add_body(world, scene.bodies[i], static_cast<int>(i));
  number_unknowns(world);
  return world;
}

void number_unknowns(World& world) {
  world.unknown_count = 0;
  const auto take = [&](bool moves, int count) {
    if (!moves) return kNoUnknown;
    const int first = world.unknown_count;
    world.unknown_count += count;
    return first;
  };
  for (const BodyRange& body : world.bodies) {
    for (int i = 0; i < body.node_count; ++i) {
      Node& node = world.nodes[static_cast<std::size_t>(body.first_node + i)];
      node.unknown = take(!node.pinned && !body.asleep, 3);
    }
    if (body.rigid < 0) continue;
    RigidBody& rigid = world.rigid_bodies[static_cast<std::size_t>(body.rigid)];
    rigid.unknown = take(rigid.free && !body.asleep, 6);
  }
}

PrescribedState prescribed_state(const RigidBody& body, double time_s) {
  const PrescribedMotion& motion = body.prescribed;
  const double rate_rad_s = 2.0 * std::numbers::pi * motion.frequency_hz;
  const double offset_m =
      motion.velocity_m_s * time_s + motion.amplitude_m * std::sin(rate_rad_s * time_s);
  const double speed_m_s =
      motion.velocity_m_s + motion.amplitude_m * rate_rad_s * std::cos(rate_rad_s * time_s);
  return {body.start_m + offset_m * motion.direction, speed_m_s * motion.direction};
}

bool is_moved(const RigidBody& body) {
  const PrescribedMotion& motion = body.prescribed;
  return motion.velocity_m_s != 0.0 || motion.amplitude_m * motion.frequency_hz != 0.0;
}

Eigen::Matrix3d world_inertia_kg_m2(const RigidBody& body) {
  const Eigen::Matrix3d r = body.orientation.toRotationMatrix();
  return r * body.inertia_kg_m2.asDiagonal() * r.transpose();
}

double kinetic_energy_J(const RigidBody& body) {
  const Eigen::Vector3d spin_rad_s = body.orientation.conjugate() * body.angular_velocity_rad_s;
  return 0.5 * body.mass_kg * body.velocity_m_s.squaredNorm() +
         0.5 * spin_rad_s.cwiseAbs2().dot(body.inertia_kg_m2);
}

double spring_energy_J(const Spring& spring, const Node& a, const Node& b) {
  const double stretch_m = (b.position_m - a.position_m).norm() - spring.rest_length_m;
  return 0.5 * spring.stiffness_N_m * stretch_m * stretch_m;
}

double mechanical_energy_J(const World& world) {
  double energy_J = 0.0;
  for (const Node& node : world.nodes)
    if (!node.pinned)
      energy_J += node.mass_kg *
                  (0.5 * node.velocity_m_s.squaredNorm() - world.gravity_m_s2.dot(node.position_m));
  for (const RigidBody& body : world.rigid_bodies)
    if (body.free)
      energy_J += kinetic_energy_J(body) - body.mass_kg * world.gravity_m_s2.dot(body.position_m);
  for (const Spring& spring : world.springs)
    energy_J += spring_energy_J(spring, world.nodes[static_cast<std::size_t>(spring.a)],
                                world.nodes[static_cast<std::size_t>(spring.b)]);
  return energy_J;
}

}  // namespace stillgrid
