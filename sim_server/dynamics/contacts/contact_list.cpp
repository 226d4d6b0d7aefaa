#include "sim_server/dynamics/contacts/contact_list.hpp"

#include <algorithm>

#include "sim_server/bodies/sphere_motion.hpp"

namespace stillgrid::dynamics {
namespace {

using Eigen::Vector3d;

/// What one thread takes at once.
constexpr std::size_t kSpheresAChunk = 1024, kTouchesAChunk = 64;

/// The centre of a sphere, and its velocity.
bodies::SphereMotion motion_of(const bodies::SphereBinding& binding, const ExplicitState& state) {
  if (binding.rigid >= 0) {
    const RigidState& body = state.rigid[static_cast<std::size_t>(binding.rigid)];
    const Vector3d arm_m = body.rotation * binding.local_m;
    return {body.position_m + arm_m, body.velocity_m_s + body.spin_rad_s.cross(arm_m)};
  }
  bodies::SphereMotion sum{Vector3d::Zero(), Vector3d::Zero()};
  for (std::size_t i = 0; i < static_cast<std::size_t>(binding.node_count); ++i) {
    const auto node = static_cast<std::size_t>(binding.nodes[i]);
    sum.position_m += binding.weights[i] * state.position_m[node].map();
    sum.velocity_m_s += binding.weights[i] * state.velocity_m_s[node].map();
  }
  return sum;
}

}  // namespace

Vector3d way_m_s(const contact::Contact& contact, double part_s) {
  return (contact.position_b_m - contact.start_b_m) / part_s;
}

void ContactList::take(const bodies::World& world, std::span<const contact::Contact> contacts) {
  for (const ContactSphere& sphere : spheres_)
    if (static_cast<std::size_t>(sphere.number) < place_of_.size())
      place_of_[static_cast<std::size_t>(sphere.number)] = -1;
  place_of_.resize(world.spheres.size(), -1);
  spheres_.clear();
  pairs_.clear();
  touches_.clear();
  std::size_t touches = 0;
  for (const contact::Contact& contact : contacts)
    for (const int number : {contact.a, contact.b}) {
      if (bodies::is_field(world, number))
        ++touches;
      else if (number >= 0)
        place_of_[static_cast<std::size_t>(number)] = 0;
    }
  // In the order of their numbers, or what touches would be far apart in memory.
  for (std::size_t i = 0; i < place_of_.size(); ++i) {
    if (place_of_[i] < 0) continue;
    place_of_[i] = static_cast<int>(spheres_.size());
    const bodies::SphereBinding& binding = world.spheres[i];
    const bool is_moved =
        binding.rigid >= 0 &&
        world.rigid_bodies[static_cast<std::size_t>(binding.rigid)].unknown != bodies::kNoUnknown;
    spheres_.push_back({.number = static_cast<int>(i),
                        .rigid = is_moved ? binding.rigid : -1,
                        .binding = &binding});
  }
  const auto place_of = [&](int number) {
    return number < 0 || bodies::is_field(world, number)
               ? -1
               : place_of_[static_cast<std::size_t>(number)];
  };
  memories_.take(world, contacts);
  touches_.reserve(touches);  // which spheres point into
  for (const ContactMemories::Place& place : memories_.places()) {
    const contact::Contact& contact = contacts[place.contact];
    const bool turned = is_turned(contact);
    pairs_.push_back({place_of(turned ? contact.b : contact.a),
                      place_of(turned ? contact.a : contact.b),
                      turned ? contact.radius_b_m : contact.radius_a_m,
                      contact.radius_a_m + contact.radius_b_m, &contact});
    for (const int number : {contact.a, contact.b})
      if (bodies::is_field(world, number)) add_touch(world, pairs_.size() - 1, number);
  }
}

/// A field as a sphere of its own in each pair.
void ContactList::add_touch(const bodies::World& world, std::size_t number_of_pair, int number) {
  const bodies::FieldBody& field = bodies::field_of(world, number);
  ContactPair& pair = pairs_[number_of_pair];
  pair.touch = static_cast<int>(touches_.size());
  const auto place = static_cast<int>(spheres_.size());
  (pair.contact->a == number ? pair.a : pair.b) = place;
  ContactTouch& touch = touches_.emplace_back();
  touch.pair = number_of_pair;
  touch.sphere = place;
  touch.field = &field;
  if (field.rigid < 0) touch.pose = contact::pose_of(field, {});
  touch.binding.body = field.body;
  touch.binding.rigid = field.rigid;
  const bool is_moved =
      field.rigid >= 0 &&
      world.rigid_bodies[static_cast<std::size_t>(field.rigid)].unknown != bodies::kNoUnknown;
  spheres_.push_back(
      {.number = number, .rigid = is_moved ? field.rigid : -1, .binding = &touch.binding});
}

void ContactList::place(const ExplicitState& state, double share, double substep_s,
                        const Vector3d& gravity_m_s2, const Workers& workers) {
  workers.for_each(spheres_.size() - touches_.size(), kSpheresAChunk,
                   [&](std::size_t i) { place(spheres_[i], state, substep_s, gravity_m_s2); });
  workers.for_each(touches_.size(), kTouchesAChunk, [&](std::size_t i) {
    place(touches_[i], state, share, substep_s, gravity_m_s2);
  });
}

/// The tangent sphere where the other one is.
void ContactList::place(ContactTouch& touch, const ExplicitState& state, double share,
                        double substep_s, const Vector3d& gravity_m_s2) {
  const ContactPair& pair = pairs_[touch.pair];
  const contact::Contact& contact = *pair.contact;
  const bool is_first = pair.a == touch.sphere;
  const Vector3d other_m = is_first ? contact::kinematic_position_m(contact, share)
                                    : Vector3d(sphere(pair.a).position_m.map());
  ContactSphere& own = spheres_[static_cast<std::size_t>(touch.sphere)];
  own.speed_m_s = 0.0;
  contact::FieldPose pose = touch.pose;
  if (touch.field->rigid >= 0) {
    const RigidState& body = state.rigid[static_cast<std::size_t>(touch.field->rigid)];
    pose = {body.position_m, body.rotation};
    own.speed_m_s = (body.velocity_m_s + body.spin_rad_s.cross(other_m - body.position_m)).norm();
    if (body.free) own.speed_m_s += substep_s * gravity_m_s2.norm();
  }
  const contact::FieldTouch at = contact::touch_of(
      *touch.field, pose, other_m, is_first ? contact.radius_b_m : contact.radius_a_m);
  own.position_m.map() = at.centre_m;
  own.arm_m.map() = at.centre_m - pose.position_m;
  touch.material = contact::scaled(contact, at).material;
}

void ContactList::place(ContactSphere& sphere, const ExplicitState& state, double substep_s,
                        const Vector3d& gravity_m_s2) {
  const bodies::SphereBinding& binding = *sphere.binding;
  if (binding.rigid >= 0) {
    const RigidState& body = state.rigid[static_cast<std::size_t>(binding.rigid)];
    const Vector3d arm_m = body.rotation * binding.local_m;
    sphere.arm_m.map() = arm_m;
    sphere.position_m.map() = body.position_m + arm_m;
    sphere.speed_m_s = (body.velocity_m_s + body.spin_rad_s.cross(arm_m)).norm();
    if (body.free) sphere.speed_m_s += substep_s * gravity_m_s2.norm();
    return;
  }
  Vector3d position_m = Vector3d::Zero(), velocity_m_s = Vector3d::Zero(),
           change_m_s2 = Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(binding.node_count); ++i) {
    const auto node = static_cast<std::size_t>(binding.nodes[i]);
    const double inverse_mass_per_kg = state.inverse_mass_per_kg[node];
    if (inverse_mass_per_kg > 0.0)
      change_m_s2 +=
          binding.weights[i] * (inverse_mass_per_kg * state.force_N[node].map() + gravity_m_s2);
    position_m += binding.weights[i] * state.position_m[node].map();
    velocity_m_s += binding.weights[i] * state.velocity_m_s[node].map();
  }
  sphere.position_m.map() = position_m;
  sphere.speed_m_s = velocity_m_s.norm() + substep_s * change_m_s2.norm();
}

Vector3d ContactList::other_m(const ContactPair& pair, double share) const {
  return pair.b >= 0 ? Vector3d(sphere(pair.b).position_m.map())
                     : contact::kinematic_position_m(*pair.contact, share);
}

bool ContactList::is_near(const ContactPair& pair, double share, double part_s,
                          double substep_s) const {
  const contact::Contact& contact = *pair.contact;
  const ContactSphere& a = sphere(pair.a);
  // Twice the way of half a substep, and what its forces add.
  const double way_m = substep_s * a.speed_m_s;
  if (contact.is_plane)
    return contact.plane_normal.dot(a.position_m.map()) - contact.plane_offset_m <
           contact.radius_a_m + way_m;
  const double other_m_s = pair.b >= 0 ? sphere(pair.b).speed_m_s : way_m_s(contact, part_s).norm();
  const double within_m = pair.distance_m + way_m + substep_s * other_m_s;
  return (a.position_m.map() - other_m(pair, share)).squaredNorm() < within_m * within_m;
}

int ContactList::count_touching(const ExplicitState& state, const Workers& workers) {
  place(state, 1.0, 0.0, Vector3d::Zero(), workers);
  return static_cast<int>(std::count_if(pairs_.begin(), pairs_.end(), [&](const ContactPair& pair) {
    const contact::Contact& contact = *pair.contact;
    const Vector3d a_m = sphere(pair.a).position_m.map();
    if (contact.is_plane)
      return contact.plane_normal.dot(a_m) - contact.plane_offset_m < contact.radius_a_m;
    return (a_m - other_m(pair, 1.0)).squaredNorm() < pair.distance_m * pair.distance_m;
  }));
}

double ContactList::approach_per_s(const ExplicitState& state, double part_s) const {
  double most_per_s = 0.0;
  for (const ContactPair& pair : pairs_) {
    const contact::Contact& contact = *pair.contact;
    if (contact.is_plane) continue;
    if (pair.touch >= 0) {
      most_per_s = std::max(most_per_s, field_approach_per_s(pair, state, part_s));
      continue;
    }
    const bodies::SphereMotion a = motion_of(*sphere(pair.a).binding, state);
    const bodies::SphereMotion b =
        pair.b >= 0 ? motion_of(*sphere(pair.b).binding, state)
                    : bodies::SphereMotion{contact.start_b_m, way_m_s(contact, part_s)};
    const double apart_m_s = (a.velocity_m_s - b.velocity_m_s).norm();
    // What is merely listed says nothing, or the list would be seen in the motion.
    const double within_m = pair.distance_m + apart_m_s * part_s;
    if ((a.position_m - b.position_m).squaredNorm() > within_m * within_m) continue;
    most_per_s = std::max(most_per_s, apart_m_s / std::min(contact.radius_a_m, contact.radius_b_m));
  }
  return most_per_s;
}

/// As of spheres as small as a field's cells: no solid is thinner, and no edge sharper.
double ContactList::field_approach_per_s(const ContactPair& pair, const ExplicitState& state,
                                         double part_s) const {
  const ContactTouch& touch = touches_[static_cast<std::size_t>(pair.touch)];
  const contact::Contact& contact = *pair.contact;
  const bool is_first = pair.a == touch.sphere;
  const double radius_m = is_first ? contact.radius_b_m : contact.radius_a_m;
  bodies::SphereMotion other{contact.start_b_m, way_m_s(contact, part_s)};
  if (!is_first) other = motion_of(*sphere(pair.a).binding, state);
  contact::FieldPose pose = touch.pose;
  if (touch.field->rigid >= 0) {
    const RigidState& body = state.rigid[static_cast<std::size_t>(touch.field->rigid)];
    pose = {body.position_m, body.rotation};
    other.velocity_m_s -=
        body.velocity_m_s + body.spin_rad_s.cross(other.position_m - body.position_m);
  }
  const double apart_m_s = other.velocity_m_s.norm();
  const double gap_m = contact::gap_m(*touch.field, pose.into(other.position_m), radius_m);
  return gap_m > apart_m_s * part_s ? 0.0 : apart_m_s / (radius_m + contact::cell_m(*touch.field));
}

}  // namespace stillgrid::dynamics
