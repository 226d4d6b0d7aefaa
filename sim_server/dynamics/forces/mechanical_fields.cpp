// Where a mechanical system meets fields: as the spheres that they are wherever it is placed.

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/contact/sticking.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"

namespace stillgrid::dynamics {

void MechanicalSystem::add_touch(Candidate& candidate) {
  const contact::Contact& contact = contacts_[static_cast<std::size_t>(candidate.contact)];
  const bool is_first = bodies::is_field(*world_, contact.a);
  const bodies::FieldBody& field = bodies::field_of(*world_, is_first ? contact.a : contact.b);
  candidate.touch = static_cast<int>(touches_.size());
  Touch& touch =
      touches_.emplace_back(Touch{.field = &field,
                                  .other = is_first ? -1 : contact.a,
                                  .radius_m = is_first ? contact.radius_b_m : contact.radius_a_m,
                                  .contact = &contact});
  touch.binding.body = field.body;
  touch.binding.material = field.material;
  touch.binding.radius_m = contact::tangent_radius_m(field);
  touch.binding.rigid = field.rigid;
  const Eigen::Vector3d other_m =
      touch.other < 0
          ? contact.start_b_m
          : bodies::sphere_motion(*world_, world_->spheres[static_cast<std::size_t>(touch.other)])
                .position_m;
  const contact::FieldTouch start = contact::touch_of(
      field, contact::pose_of(field, world_->rigid_bodies), other_m, touch.radius_m);
  candidate.stretch_m = contact::stretched_as(candidate.stretch_m, 1.0, start.stiffness_scale);
  if (levers_ != Levers::kMean || !(contact.depth_before_m > 0.0)) return;
  candidate.start_m = is_first ? Eigen::Vector3d(-start.normal) : start.normal;
}

/// The tangent sphere where all is.
void MechanicalSystem::place(Touch& touch) const {
  const bodies::FieldBody& field = *touch.field;
  const Eigen::Vector3d other_m =
      touch.other < 0 ? touch.contact->position_b_m
                      : trial_.spheres[static_cast<std::size_t>(touch.other)].position_m;
  const contact::FieldPose pose = contact::pose_of(field, trial_.rigid_bodies);
  touch.at = contact::touch_of(field, pose, other_m, touch.radius_m);
  touch.binding.local_m = pose.into(touch.at.centre_m);
  touch.motion = {touch.at.centre_m, Eigen::Vector3d::Zero()};
  if (field.rigid < 0) return;
  const bodies::RigidBody& body = trial_.rigid_bodies[static_cast<std::size_t>(field.rigid)];
  touch.motion.velocity_m_s =
      body.velocity_m_s + body.angular_velocity_rad_s.cross(touch.at.centre_m - body.position_m);
}

const contact::Contact& MechanicalSystem::contact_at(const Candidate& candidate,
                                                     contact::Contact& own) const {
  const contact::Contact& contact = contacts_[static_cast<std::size_t>(candidate.contact)];
  if (candidate.touch < 0) return contact;
  return own = contact::scaled(contact, touches_[static_cast<std::size_t>(candidate.touch)].at);
}

const bodies::SphereBinding& MechanicalSystem::binding_of(const Candidate& candidate,
                                                          int number) const {
  return bodies::is_field(*world_, number)
             ? touches_[static_cast<std::size_t>(candidate.touch)].binding
             : world_->spheres[static_cast<std::size_t>(number)];
}

}  // namespace stillgrid::dynamics
