#include "tests/laboratory/rivals/force_jacobian.hpp"

#include "shared/rendering/velocity_estimator.hpp"

namespace stillgrid::laboratory {
namespace {

using Twist = Eigen::Matrix<double, 6, 1>;

Twist stacked(const Eigen::Vector3d& along, const Eigen::Vector3d& about) {
  Twist twist;
  twist << along, about;
  return twist;
}

rendering::ToolPose moved(const rendering::ToolPose& pose, const Twist& way) {
  rendering::ToolPose there = pose;
  there.position_m += way.head<3>();
  const double angle_rad = way.tail<3>().norm();
  if (angle_rad > 0.0)
    there.orientation =
        Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(way.tail<3>() / angle_rad)) * pose.orientation;
  return there;
}

rendering::ToolPose sped_up(const rendering::ToolPose& pose, const Twist& velocity) {
  rendering::ToolPose faster = pose;
  faster.velocity_m_s += velocity.head<3>();
  faster.angular_velocity_rad_s += velocity.tail<3>();
  return faster;
}

}  // namespace

void ForceJacobian::update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool&,
                           bool) noexcept {
  const auto force_at = [&](const rendering::ToolPose& pose) {
    rendering::ToolSpheres spheres;
    return rendering::tool_force(scene.fixed, scene.patch,
                                 rendering::place_tool(scene.fixed, pose, spheres), pose);
  };
  const auto wrench_at = [&](const rendering::ToolPose& pose) {
    const rendering::ToolForce force = force_at(pose);
    return stacked(force.force_N, force.torque_N_m);
  };
  pose_ = sampled.pose;
  at_sample_ = force_at(pose_);
  wrench_ = stacked(at_sample_.force_N, at_sample_.torque_N_m);
  by_place_.setZero();
  by_velocity_.setZero();
  if (at_sample_.contacts == 0) return;
  // Differences of the law itself: whatever it holds, its derivative is here.
  constexpr double kStep = 1e-7;  // m, rad, m/s, rad/s
  for (int i = 0; i < 6; ++i) {
    const Twist step = kStep * Twist::Unit(i);
    by_place_.col(i) =
        (wrench_at(moved(pose_, step)) - wrench_at(moved(pose_, -step))) / (2.0 * kStep);
    by_velocity_.col(i) =
        (wrench_at(sped_up(pose_, step)) - wrench_at(sped_up(pose_, -step))) / (2.0 * kStep);
  }
}

rendering::ToolForce ForceJacobian::force(const LocalScene&, const PlacedTool& tool) noexcept {
  const Eigen::Quaterniond turn = tool.pose.orientation * pose_.orientation.conjugate();
  const Twist way = stacked(tool.pose.position_m - pose_.position_m, rendering::rotation_rad(turn));
  const Twist gained = stacked(tool.pose.velocity_m_s - pose_.velocity_m_s,
                               tool.pose.angular_velocity_rad_s - pose_.angular_velocity_rad_s);
  const Twist wrench = wrench_ + by_place_ * way + by_velocity_ * gained;
  return {wrench.head<3>(), wrench.tail<3>(), at_sample_.contacts, at_sample_.stiffness_N_per_m};
}

}  // namespace stillgrid::laboratory
