#include "sim_server/snapshot/moving_fields.hpp"

#include <utility>
#include <vector>

namespace stillgrid::snapshot {

proto::FieldState state_of(const bodies::World& world, const bodies::FieldBody& field) noexcept {
  if (field.rigid < 0)
    return publication::field_state(field.position_m, field.orientation, Eigen::Vector3d::Zero(),
                                    Eigen::Vector3d::Zero());
  const bodies::RigidBody& body = world.rigid_bodies[static_cast<std::size_t>(field.rigid)];
  const Eigen::Vector3d arm_m = body.orientation * field.position_m;
  return publication::field_state(body.position_m + arm_m, body.orientation * field.orientation,
                                  body.velocity_m_s + body.angular_velocity_rad_s.cross(arm_m),
                                  body.angular_velocity_rad_s);
}

publication::MovingFields moving_fields(const bodies::World& world) {
  std::vector<std::size_t> moving;
  for (std::size_t i = 0; i < world.fields.size(); ++i)
    if (world.fields[i].rigid >= 0) moving.push_back(i);
  publication::MovingFields fields(std::move(moving));
  show(world, fields);
  return fields;
}

void show(const bodies::World& world, publication::MovingFields& fields) noexcept {
  fields.show([&](std::size_t field) { return state_of(world, world.fields[field]); });
}

}  // namespace stillgrid::snapshot
