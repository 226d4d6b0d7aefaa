// Checks of a model beyond the range of each number.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include "proto/tool_segment.hpp"
#include "shared/dynamics/scene_model.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kUnitRounding = 1e-6;  // of a length that is one

void require(bool is_right, const char* what) {
  if (!is_right) throw std::invalid_argument(what);
}
/// Requires is_right(item) of all items.
template <class Items, class Check>
void require_each(const Items& items, const char* what, const Check& is_right) {
  const auto wrong = std::ranges::find_if_not(items, is_right);
  if (wrong != items.end())
    throw std::invalid_argument(std::string(what) + " " + std::to_string(wrong - items.begin()));
}

/// Whether all are zero or above. A denormal number is neither: a tick takes it as zero, and what
/// is made before the first tick does not.
template <class... Numbers>
bool none_negative(Numbers... numbers) {
  const auto is_zero = [](double number) { return std::bit_cast<std::uint64_t>(number) << 1 == 0; };
  return (... && (is_zero(numbers) || numbers >= std::numeric_limits<double>::min()));
}
bool is_one(double length) {
  return std::abs(length - 1.0) < kUnitRounding;
}

/// Whether a sphere is on a rigid body, or on nodes whose weights sum to one.
bool is_bound(const Description::Sphere& sphere) {
  if (sphere.rigid >= 0) return sphere.node_count == 0;
  double sum = 0.0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(sphere.node_count); ++k)
    sum += sphere.weights[k];
  return sphere.rigid == -1 && is_one(sum);
}

bool is_joint(const Description::Joint& joint) {
  const auto is_end = [](const Description::JointEnd& end) {
    return std::min(end.node, end.rigid) == -1;
  };
  const bool joins_nodes = joint.a.node >= 0 && joint.b.node >= 0;
  return is_end(joint.a) && is_end(joint.b) && (joins_nodes || joint.rest_length_m == 0.0);
}

void check_moving(const Description& description) {
  require_each(description.nodes, "expected a mass of node",
               [](const auto& node) { return none_negative(node.mass_kg); });
  const auto is_elastic = [](const auto& spring) {
    return none_negative(spring.rest_length_m, spring.stiffness_N_per_m, spring.damping_N_s_per_m);
  };
  require_each(description.springs, "expected a length, stiffness and damping of spring",
               is_elastic);
  require_each(description.joints, "expected a length, stiffness and damping of joint", is_elastic);
  require_each(description.joints, "expected two ends of joint", is_joint);
  require_each(description.rigid_bodies, "expected a mass and inertia of rigid body",
               [](const auto& rigid) {
                 return none_negative(rigid.mass_kg, rigid.inertia_kg_m2.minCoeff());
               });
  require_each(description.rigid_bodies, "expected a fixture that is driven as rigid body",
               [](const auto& rigid) { return rigid.is_driven || !rigid.is_fixture; });
  require_each(description.bodies, "expected nodes, or a rigid body, of body",
               [](const auto& body) { return body.rigid >= -1; });
  require_each(
      description.bodies, "expected a rest speed and a radius of body",
      [](const auto& body) { return none_negative(body.rest_speed_m_s, body.bounding_radius_m); });
}

void check_collision(const Description& description) {
  require_each(description.spheres, "expected a rigid body, or nodes, of sphere", is_bound);
  require_each(description.spheres, "expected a radius and a slip speed of sphere",
               [](const auto& sphere) {
                 return none_negative(sphere.radius_m, sphere.tool_slip_speed_m_s);
               });
  require_each(description.planes, "expected a unit normal of plane",
               [](const auto& plane) { return is_one(plane.normal.norm()); });
  require_each(description.materials, "expected constants above zero of material",
               [](const auto& material) {
                 return none_negative(material.stiffness_N_per_m, material.damping_N_s_per_m,
                                      material.friction, material.slip_speed_m_s) &&
                        material.slip_speed_m_s > 0.0;
               });
  require_each(description.apart, "expected two bodies, the smaller first, as pair",
               [](const auto& pair) { return pair.first >= -1 && pair.first < pair.second; });
  const auto spheres = static_cast<int>(description.spheres.size());
  require_each(description.apart_spheres, "expected two spheres, the smaller first, as pair",
               [&](const auto& pair) {
                 return pair.first >= 0 && pair.first < pair.second && pair.second < spheres;
               });
  require(std::ranges::is_sorted(description.apart) &&
              std::ranges::is_sorted(description.apart_spheres),
          "expected sorted pairs that never collide");
}

void check_start(const SceneState& start, const Description& description) {
  const std::size_t nodes = description.nodes.size(), bodies = description.rigid_bodies.size();
  require(start.node_position_m.size() == nodes && start.node_velocity_m_s.size() == nodes,
          "expected a position and a velocity of each node");
  require(start.rigid_position_m.size() == bodies && start.rigid_velocity_m_s.size() == bodies &&
              start.orientation.size() == bodies && start.angular_velocity_rad_s.size() == bodies &&
              start.is_here.size() == bodies,
          "expected a pose and velocities of each rigid body");
  require_each(start.orientation, "expected a unit quaternion of rigid body",
               [](const Vector4& q) { return is_one(q.quaternion().norm()); });
  for (std::size_t r = 0; r < bodies; ++r)
    require(
        start.is_here[r] == 1 || (start.is_here[r] == 0 && description.rigid_bodies[r].is_driven),
        "expected rigid bodies that are here, or driven and away");
  require(none_negative(start.contacts.stiffness_per_s2, start.contacts.damping_per_s),
          "expected rates of contacts that are not negative");
}

/// The first driven bodies are the prescribed ones.
void check_prescribed(const SceneModel& model) {
  require_each(model.prescribed, "expected a unit direction of prescribed motion",
               [](const auto& motion) { return is_one(motion.direction.norm()); });
  require_each(model.prescribed, "expected ascending times of the keyframes of prescribed motion",
               [](const PrescribedMotion& motion) {
                 double before_s = 0.0;
                 for (std::size_t k = 0; motion.keyframes && k < motion.keyframes->size(); ++k) {
                   const double time_s = (*motion.keyframes)[k].time_s;
                   if (!(time_s > before_s)) return false;
                   before_s = time_s;
                 }
                 return true;
               });
  auto motion = model.prescribed.begin();
  require_each(model.description.rigid_bodies, "expected no motion of a fixture: rigid body",
               [&](const auto& rigid) {
                 const bool has_motion = rigid.is_driven && motion != model.prescribed.end();
                 return !has_motion || !(motion++)->moves() || !rigid.is_fixture;
               });
}

}  // namespace

void validate(const SceneModel& model) {
  validate(model.description);
  check_moving(model.description);
  check_collision(model.description);
  check_start(model.start, model.description);
  check_prescribed(model);
  require(model.hands <= proto::kMaxHands, "expected at most four hands");
  const auto driven = std::ranges::count_if(model.description.rigid_bodies,
                                            [](const auto& rigid) { return rigid.is_driven; });
  require(static_cast<std::size_t>(driven) ==
              model.prescribed.size() + (model.has_static_body ? 1 : 0) + model.hands,
          "expected as many driven bodies as motions, a static body and hands");
  require(model.tolerance_m_s > 0.0, "expected a tolerance above zero");
}

}  // namespace stillgrid::dynamics
