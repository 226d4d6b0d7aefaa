#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "shared/collision/contact_law.hpp"
#include "shared/collision/distance_field.hpp"
#include "sim_server/bodies/motion.hpp"

namespace stillgrid::bodies {

/// A point mass of a deformable body.
struct Node {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  double mass_kg = 0.0;
  bool pinned = false;
};

/// A spring with a damper along it, between two nodes.
struct Spring {
  int a = 0, b = 0;  // nodes
  double rest_length_m = 0.0;
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
};

/// An end of a joint: a node, a point of a rigid body, or a place of the world.
struct JointEnd {
  int body = -1;  // order in the scene file; -1: none
  int node = -1, rigid = -1;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  // in the rigid body's frame, or the world's
};

/// A spring with a damper between two ends, at rest as they are at the start. Ends that are not
/// both nodes are together there, so that it resists alike in every direction.
struct Joint {
  JointEnd a = {}, b = {};  // a node first
  double rest_length_m = 0.0;
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
};

/// A rigid body, free or moved as prescribed.
struct RigidBody {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // centre of mass
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  // world frame
  double mass_kg = 0.0;
  Eigen::Vector3d inertia_kg_m2 = Eigen::Vector3d::Zero();  // principal, body frame
  double bounding_radius_m = 0.0;  // farthest point from the centre: turns spin into a speed
  bool free = false;               // not prescribed

  PrescribedMotion prescribed;
};

/// How a collision sphere follows its body: a fixed point of a rigid body, or a weighted sum of
/// nodes.
struct SphereBinding {
  int body = 0;
  int material = 0;
  double radius_m = 0.0;
  int rigid = -1;  // index into World::rigid_bodies, or nodes below
  Eigen::Vector3d local_m = Eigen::Vector3d::Zero();  // in the rigid body's frame
  int node_count = 0;
  std::array<int, 4> nodes{};
  std::array<double, 4> weights{};                            // sum to one
  Eigen::Vector3d rest_position_m = Eigen::Vector3d::Zero();  // of the undeformed body
  // A point of the surface of a body with a distance field: it meets planes and the fields of other
  // bodies, and nothing else does, for their spheres and the tool meet its body's field.
  bool is_field_point = false;
  double crushing_force_N = 0.0;  // see SphereRecord
};

/// A rigid or static body that is met through its distance field, or one of its exact shapes.
struct FieldBody {
  int body = 0;
  int material = 0;
  int rigid = -1;  // index into World::rigid_bodies; -1: it never moves
  // Pose of the field's frame in the rigid body's, or in the world where it never moves.
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  std::shared_ptr<const collision::DistanceField> field;
};

/// A sphere that never moves.
struct StaticSphere {
  Eigen::Vector3d position_m;
  double radius_m;
  int material;
  int body;
};

/// Solid below: points with normal . x < offset_m are inside.
struct StaticPlane {
  Eigen::Vector3d normal;
  double offset_m;
  int material;
  int body;
};

/// Which of the world's arrays' items are a body's, and whether it rests.
struct BodyRange {
  std::string name;
  int first_node = 0, node_count = 0;
  int first_spring = 0, spring_count = 0;
  int first_sphere = 0, sphere_count = 0;
  Eigen::Vector2i sheet_nodes = Eigen::Vector2i::Zero();  // of a sheet: along x, y
  int rigid = -1;
  bool is_sleeping = false;  // stays as it is, out of the work, until something touches it
};

/// All that is simulated, as plain arrays joined by indices. SI units, world frame.
struct World {
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
  double time_s = 0.0;
  std::vector<Node> nodes;
  std::vector<Spring> springs;
  std::vector<RigidBody> rigid_bodies;
  std::vector<Joint> joints;
  std::vector<std::pair<int, int>> apart;  // bodies that do not collide, ascending, either way
  std::vector<SphereBinding> spheres;      // of free and of prescribed bodies
  std::vector<StaticSphere> static_spheres;
  std::vector<StaticSphere> static_points;  // field points, as SphereBinding::is_field_point
  std::vector<StaticPlane> planes;
  std::vector<FieldBody> fields;
  std::vector<collision::ContactMaterial> materials;
  std::vector<BodyRange> bodies;  // in the order of the scene file
};

/// Whether two bodies, or spheres of one, may collide as far as joints go.
[[nodiscard]] inline bool may_collide(const World& world, int a, int b) {
  return world.apart.empty() || !std::ranges::binary_search(world.apart, std::pair{a, b});
}

/// Position and velocity of a prescribed motion at time_s.
struct PrescribedState {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
};
[[nodiscard]] PrescribedState prescribed_state(const RigidBody& body, double time_s);

[[nodiscard]] double kinetic_energy_J(const RigidBody& body);
/// Returns the energy of a spring, J, from its length between two nodes.
[[nodiscard]] double spring_energy_J(const Spring& spring, const Node& a, const Node& b);

/// Kinetic, gravity and spring energy of everything free, joints' too. Contacts apart.
[[nodiscard]] double mechanical_energy_J(const World& world);

}  // namespace stillgrid::bodies
