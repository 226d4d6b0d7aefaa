#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "shared/collision/contact_law.hpp"
#include "shared/collision/distance_field.hpp"

namespace stillgrid::dynamics {

/// The constants of a scene, in SI units: masses, springs and shapes. Arrays are joined by indices.
/// `Engine` holds one and never changes it.
struct Description {
  /// A point mass of a deformable body.
  struct Node {
    double mass_kg = 0.0;
    bool is_pinned = false;  // never moves
  };
  /// A spring with a damper along the line between two nodes.
  struct Spring {
    int a = 0, b = 0;  // nodes
    double rest_length_m = 0.0;
    double stiffness_N_per_m = 0.0;
    double damping_N_s_per_m = 0.0;
  };
  /// An end of a joint: a node, a point in the frame of a rigid body, or else a place of the world.
  struct JointEnd {
    int node = -1, rigid = -1;
    Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  };
  /// A spring with a damper between two ends. It acts along the line between them on two nodes, and
  /// alike in every direction on other ends. A rest length above zero is for two nodes.
  struct Joint {
    JointEnd a, b;
    double rest_length_m = 0.0;
    double stiffness_N_per_m = 0.0;
    double damping_N_s_per_m = 0.0;
  };
  /// A rigid body that moves by forces, or a driven one: its pose is an input of each tick. Tools,
  /// prescribed bodies and bodies that never move are driven.
  struct Rigid {
    double mass_kg = 0.0;                                     // ignored where driven
    Eigen::Vector3d inertia_kg_m2 = Eigen::Vector3d::Zero();  // principal axes are the body's frame
    bool is_driven = false;
    bool is_fixture = false;  // driven, and never moves
  };
  /// A collision sphere: a fixed point of a rigid body, or a weighted sum of nodes.
  struct Sphere {
    double radius_m = 0.0;
    int material = 0;
    int body = 0;    // spheres of one rigid body never collide; see also `apart`
    int rigid = -1;  // index of a rigid body, or -1
    Eigen::Vector3d local_m = Eigen::Vector3d::Zero();  // in the frame of the rigid body
    int node_count = 0;                                 // 1 to 4 where rigid is -1
    std::array<int, 4> nodes{};
    std::array<double, 4> weights{};  // sum to one
    /// A tool's contact has the material of the other side. It is met by its proxy: see ToolLane.
    bool is_tool = false;
    /// Above zero: the tool is met by the paper's penalty sum, without a proxy, and friction is
    /// viscous up to this speed.
    double tool_slip_speed_m_s = 0.0;
    [[nodiscard]] bool has_proxy() const { return is_tool && tool_slip_speed_m_s == 0.0; }
    /// A point of the surface of a rigid body with a field. It collides with planes and with the
    /// fields of other bodies, but with no sphere.
    bool is_field_point = false;
    double crushing_force_N = 0.0;  // see proto::SphereRecord
  };
  /// The signed distance to the surface of a rigid body. Spheres of other bodies collide with it.
  struct Field {
    std::shared_ptr<const collision::DistanceField> distance;
    int rigid = 0;
    // Pose of the field's frame in the frame of the rigid body.
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
    int material = 0;
    int body = 0;  // see Sphere::body
  };
  /// Points x with normal . x < offset_m are inside. Never moves.
  struct Plane {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    double offset_m = 0.0;
    int material = 0;
    int body = -1;  // see `apart`
  };

  /// A body that may sleep: a free rigid body, or a run of nodes.
  struct Body {
    int first_node = 0, node_count = 0;
    int rigid = -1;
    double rest_speed_m_s = 0.0;     // at rest while all its points are slower
    double bounding_radius_m = 0.0;  // rigid body: farthest point from the centre
  };

  /// A side of a contact; the other two are null.
  struct Side {
    const Sphere* sphere = nullptr;
    const Plane* plane = nullptr;
    const Field* field = nullptr;

    /// -1 for a plane and for a sphere of nodes.
    [[nodiscard]] int rigid() const {
      return sphere != nullptr ? sphere->rigid : field != nullptr ? field->rigid : -1;
    }
    [[nodiscard]] int material() const {
      return sphere != nullptr  ? sphere->material
             : plane != nullptr ? plane->material
                                : field->material;
    }
  };
  /// Returns whether a rigid body never moves; false for -1.
  [[nodiscard]] bool is_fixture(int rigid) const {
    return rigid >= 0 && rigid_bodies[static_cast<std::size_t>(rigid)].is_fixture;
  }
  /// Returns a sphere, plane or field by its number. Planes are counted on behind spheres, and
  /// fields behind planes. Pre: number < field_number(fields.size()).
  [[nodiscard]] Side side(std::size_t number) const {
    if (number < spheres.size()) return {.sphere = &spheres[number]};
    if (number < field_number(0)) return {.plane = &planes[number - spheres.size()]};
    return {.field = &fields[number - field_number(0)]};
  }
  [[nodiscard]] std::size_t field_number(std::size_t field) const {
    return spheres.size() + planes.size() + field;
  }

  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
  std::vector<Node> nodes;
  std::vector<Spring> springs;
  std::vector<Joint> joints;
  std::vector<Rigid> rigid_bodies;
  std::vector<Sphere> spheres;
  std::vector<Plane> planes;
  std::vector<Field> fields;
  std::vector<Body> bodies;  // others never sleep
  std::vector<collision::ContactMaterial> materials;
  std::vector<std::pair<int, int>> apart;  // bodies that never collide, smaller first, sorted
  std::vector<std::pair<int, int>> apart_spheres;  // spheres of one body, likewise
};

/// Throws std::invalid_argument where an index is out of range, or a mass, inertia or radius is not
/// positive.
void validate(const Description& description);

/// A number that differs between descriptions that differ in anything, but for chance.
[[nodiscard]] std::uint64_t fingerprint(const Description& description);

}  // namespace stillgrid::dynamics
