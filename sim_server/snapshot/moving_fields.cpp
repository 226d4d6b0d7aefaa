#include "sim_server/snapshot/moving_fields.hpp"

#include "shared/collision/field_history.hpp"

namespace stillgrid::snapshot {
namespace {

std::array<float, 3> floats(const Eigen::Vector3d& v) noexcept {
  const Eigen::Vector3f f = v.cast<float>();
  return {f.x(), f.y(), f.z()};
}

void go_on(proto::FieldRecord& record) noexcept {
  record.predicted_velocity_m_s = record.history[0].velocity_m_s;
  record.predicted_angular_velocity_rad_s = record.history[0].angular_velocity_rad_s;
  record.response = 0;
}

}  // namespace

proto::FieldState state_of(const bodies::World& world, const bodies::FieldBody& field) noexcept {
  const bodies::RigidBody* const body =
      field.rigid < 0 ? nullptr : &world.rigid_bodies[static_cast<std::size_t>(field.rigid)];
  const Eigen::Vector4f turn =
      (body == nullptr ? field.orientation : body->orientation).coeffs().cast<float>();
  proto::FieldState state{};
  state.position_m = floats(body == nullptr ? field.position_m : body->position_m);
  state.orientation_xyzw = {turn.x(), turn.y(), turn.z(), turn.w()};
  if (body == nullptr) return state;
  state.velocity_m_s = floats(body->velocity_m_s);
  state.angular_velocity_rad_s = floats(body->angular_velocity_rad_s);
  return state;
}

MovingFields::MovingFields(const bodies::World& world) {
  for (std::size_t i = 0; i < world.fields.size(); ++i) {
    if (world.fields[i].rigid < 0) continue;
    fields_.push_back(i);
    collision::fill_history(records_.emplace_back(proto::FieldRecord{}),
                            state_of(world, world.fields[i]));
  }
}

void MovingFields::show(const bodies::World& world) noexcept {
  for (std::size_t i = 0; i < fields_.size(); ++i)
    collision::push_snapshot(records_[i], state_of(world, world.fields[fields_[i]]));
}

void MovingFields::take(const bodies::FieldPrediction& prediction,
                        proto::FieldRecord& record) noexcept {
  record.predicted_velocity_m_s = floats(prediction.predicted_velocity_m_s);
  record.predicted_angular_velocity_rad_s = floats(prediction.predicted_angular_velocity_rad_s);
  record.response = prediction.response;
}

void MovingFields::forget_predictions() noexcept {
  for (proto::FieldRecord& record : records_) go_on(record);
}

}  // namespace stillgrid::snapshot
