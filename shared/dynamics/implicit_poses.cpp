#include "shared/dynamics/implicit_poses.hpp"

#include <algorithm>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {
namespace {

Eigen::Vector3d sum_of(const Description::Sphere& sphere, const std::vector<Vector4>& nodes) {
  Vector4 sum;
  for (std::size_t k = 0; k < at(sphere.node_count); ++k)
    sum = sum + sphere.weights[k] * nodes[at(sphere.nodes[k])];
  return sum.vector();
}

}  // namespace

ImplicitPoses::ImplicitPoses(const Description& description)
    : nodes_(description.nodes.size()), turns_(description.rigid_bodies.size()) {}

void ImplicitPoses::start(const SceneState& state, double step_s) {
  from_ = &state;
  step_s_ = step_s;
  to_.node_position_m = state.node_position_m;
  to_.rigid_position_m = state.rigid_position_m;
  to_.orientation = state.orientation;
  for (std::size_t r = 0; r < turns_.size(); ++r) {
    const Eigen::Matrix3d axes = state.orientation[r].quaternion().toRotationMatrix();
    turns_[r] = {axes, axes, axes};
  }
}

void ImplicitPoses::move(const Motions& velocities, const AwakeRuns& awake) {
  each_awake(awake, [&](std::size_t i) {
    if (i < nodes_)
      to_.node_position_m[i] = from_->node_position_m[i] + step_s_ * velocities[i];
    else if (i < nodes_ + turns_.size())
      move_body(i - nodes_, velocities);
  });
}

/// The mean arm is tan(t/2) / (t/2) times the mean of both arms, where t is the angle.
void ImplicitPoses::move_body(std::size_t r, const Motions& velocities) {
  constexpr double kSmallestCosine = 0.1;  // of half an angle: beyond it works are not exact
  to_.rigid_position_m[r] = from_->rigid_position_m[r] + step_s_ * velocities[centre(r)];
  const Eigen::Vector3d turn_rad = step_s_ * velocities[spin(r)].vector();
  const Eigen::Quaterniond rotation = rotation_by(turn_rad);
  const Eigen::Quaterniond end = (rotation * from_->orientation[r].quaternion()).normalized();
  to_.orientation[r] = Vector4(end);
  Turn& turn = turns_[r];
  turn.end = end.toRotationMatrix();
  const double square = turn_rad.squaredNorm();
  const double sine = square > 0.0 ? 2.0 * rotation.vec().dot(turn_rad) / square : 1.0;
  turn.mean =
      0.5 * sine / std::max(std::abs(rotation.w()), kSmallestCosine) * (turn.start + turn.end);
}

Eigen::Vector3d ImplicitPoses::before_m(const Description::Sphere& sphere) const {
  if (sphere.rigid < 0) return sum_of(sphere, from_->node_position_m);
  const std::size_t r = at(sphere.rigid);
  return from_->rigid_position_m[r].vector() + arm_before_m(r, sphere.local_m);
}

Eigen::Vector3d ImplicitPoses::after_m(const Description::Sphere& sphere) const {
  if (sphere.rigid < 0) return sum_of(sphere, to_.node_position_m);
  const std::size_t r = at(sphere.rigid);
  return to_.rigid_position_m[r].vector() + arm_m(r, sphere.local_m);
}

}  // namespace stillgrid::dynamics
