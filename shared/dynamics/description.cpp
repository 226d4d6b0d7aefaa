#include "shared/dynamics/description.hpp"

#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>

namespace stillgrid::dynamics {
namespace {

void require(bool is_right, const char* what, std::size_t index) {
  if (!is_right) throw std::invalid_argument(std::string(what) + " " + std::to_string(index));
}

template <class Items>
bool is_index(int index, const Items& items) {
  return index >= 0 && static_cast<std::size_t>(index) < items.size();
}

void validate_sphere(const Description& description, std::size_t i) {
  const Description::Sphere& sphere = description.spheres[i];
  require(sphere.radius_m > 0.0, "expected a positive radius of sphere", i);
  require(is_index(sphere.material, description.materials), "unknown material of sphere", i);
  if (sphere.rigid >= 0) {
    require(is_index(sphere.rigid, description.rigid_bodies), "unknown rigid body of sphere", i);
    return;
  }
  require(sphere.node_count >= 1 && sphere.node_count <= 4, "expected 1 to 4 nodes of sphere", i);
  for (int k = 0; k < sphere.node_count; ++k)
    require(is_index(sphere.nodes[static_cast<std::size_t>(k)], description.nodes),
            "unknown node of sphere", i);
}

void validate_field(const Description& description, std::size_t i) {
  const Description::Field& field = description.fields[i];
  require(field.distance != nullptr, "expected a distance of field", i);
  require(is_index(field.rigid, description.rigid_bodies), "unknown rigid body of field", i);
  require(is_index(field.material, description.materials), "unknown material of field", i);
  require(std::abs(field.orientation.norm() - 1.0) < 1e-6 && field.position_m.allFinite(),
          "expected a pose of field", i);
}

/// FNV-1a over numbers.
class Hash {
 public:
  template <class... Numbers>
  void add(const Numbers&... numbers) {
    (add_one(static_cast<double>(numbers)), ...);
  }
  void add_vector(const Eigen::Vector3d& v) { add(v.x(), v.y(), v.z()); }
  void add_word(std::uint64_t word) {
    value_ = (value_ ^ word) * 0x100000001b3;
    value_ ^= value_ >> 29;
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  void add_one(double number) { add_word(std::bit_cast<std::uint64_t>(number)); }
  std::uint64_t value_ = 0xcbf29ce484222325;
};

void add_sphere(const Description::Sphere& sphere, Hash& hash) {
  hash.add(sphere.radius_m, sphere.material, sphere.body, sphere.rigid, sphere.node_count,
           sphere.is_tool, sphere.tool_slip_speed_m_s, sphere.is_field_point,
           sphere.crushing_force_N);
  hash.add_vector(sphere.local_m);
  for (const int node : sphere.nodes) hash.add(node);
  for (const double weight : sphere.weights) hash.add(weight);
}

void add_field(const Description::Field& field, Hash& hash) {
  const proto::FieldShape& shape = field.distance->shape();
  hash.add(field.rigid, field.material, field.body, shape.brick_m, shape.bounding_radius_m,
           shape.fine_count, shape.has_stiffness, shape.kind);
  hash.add_vector(field.position_m);
  hash.add_vector(field.orientation.vec());
  hash.add(field.orientation.w());
  for (std::size_t k = 0; k < 3; ++k)
    hash.add(shape.lowest_m[k], shape.centre_m[k], shape.bricks[k]);
  for (const std::uint64_t word : field.distance->words()) hash.add_word(word);
}

void validate_end(const Description& description, const Description::JointEnd& end, std::size_t i) {
  require(end.node < 0 || is_index(end.node, description.nodes), "unknown node of joint", i);
  require(end.rigid < 0 || is_index(end.rigid, description.rigid_bodies),
          "unknown rigid body of joint", i);
}

void validate_body(const Description& description, std::size_t i) {
  const Description::Body& body = description.bodies[i];
  const auto nodes = static_cast<int>(description.nodes.size());
  require(body.first_node >= 0 && body.node_count >= 0 && body.first_node <= nodes &&
              body.node_count <= nodes - body.first_node,
          "unknown node of body", i);
  require(
      body.rigid < 0 || (is_index(body.rigid, description.rigid_bodies) &&
                         !description.rigid_bodies[static_cast<std::size_t>(body.rigid)].is_driven),
      "expected a free rigid body of body", i);
}

}  // namespace

std::uint64_t fingerprint(const Description& description) {
  Hash hash;
  hash.add(description.joints.size());
  hash.add_vector(description.gravity_m_s2);
  hash.add(description.nodes.size(), description.springs.size(), description.rigid_bodies.size(),
           description.spheres.size(), description.planes.size(), description.materials.size(),
           description.apart.size());
  for (const auto& node : description.nodes) hash.add(node.mass_kg, node.is_pinned);
  for (const auto& spring : description.springs)
    hash.add(spring.a, spring.b, spring.rest_length_m, spring.stiffness_N_per_m,
             spring.damping_N_s_per_m);
  for (const auto& joint : description.joints) {
    hash.add(joint.rest_length_m, joint.stiffness_N_per_m, joint.damping_N_s_per_m);
    for (const auto& end : {joint.a, joint.b}) {
      hash.add(end.node, end.rigid);
      hash.add_vector(end.point_m);
    }
  }
  for (const auto& rigid : description.rigid_bodies) {
    hash.add(rigid.mass_kg, rigid.is_driven, rigid.is_fixture);
    hash.add_vector(rigid.inertia_kg_m2);
  }
  for (const auto& sphere : description.spheres) add_sphere(sphere, hash);
  for (const auto& body : description.bodies)
    hash.add(body.first_node, body.node_count, body.rigid, body.rest_speed_m_s,
             body.bounding_radius_m);
  for (const auto& plane : description.planes) {
    hash.add(plane.offset_m, plane.material, plane.body);
    hash.add_vector(plane.normal);
  }
  hash.add(description.fields.size());
  for (const auto& field : description.fields) add_field(field, hash);
  for (const auto& material : description.materials)
    hash.add(material.stiffness_N_per_m, material.damping_N_s_per_m, material.friction,
             material.slip_speed_m_s);
  for (const auto& [a, b] : description.apart) hash.add(a, b);
  for (const auto& [a, b] : description.apart_spheres) hash.add(a, b);
  return hash.value();
}

void validate(const Description& description) {
  for (std::size_t i = 0; i < description.nodes.size(); ++i)
    require(description.nodes[i].is_pinned || description.nodes[i].mass_kg > 0.0,
            "expected a positive mass of node", i);
  for (std::size_t i = 0; i < description.springs.size(); ++i)
    require(is_index(description.springs[i].a, description.nodes) &&
                is_index(description.springs[i].b, description.nodes),
            "unknown node of spring", i);
  for (std::size_t i = 0; i < description.joints.size(); ++i) {
    validate_end(description, description.joints[i].a, i);
    validate_end(description, description.joints[i].b, i);
  }
  for (std::size_t i = 0; i < description.rigid_bodies.size(); ++i) {
    const Description::Rigid& rigid = description.rigid_bodies[i];
    require(rigid.is_driven || (rigid.mass_kg > 0.0 && rigid.inertia_kg_m2.minCoeff() > 0.0),
            "expected a positive mass and inertia of rigid body", i);
  }
  for (std::size_t i = 0; i < description.spheres.size(); ++i) validate_sphere(description, i);
  for (std::size_t i = 0; i < description.fields.size(); ++i) validate_field(description, i);
  for (std::size_t i = 0; i < description.planes.size(); ++i)
    require(is_index(description.planes[i].material, description.materials),
            "unknown material of plane", i);
  for (std::size_t i = 0; i < description.bodies.size(); ++i) validate_body(description, i);
}

}  // namespace stillgrid::dynamics
