#include "sim_server/dynamics/step/tool_motion.hpp"

#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {

void ToolMotion::place(const ToolSample& sample) {
  before_ = is_here_ ? sample_ : sample;
  sample_ = sample;
  is_here_ = true;
}

void ToolMotion::add_spheres(std::vector<contact::ToolSphereMotion>& spheres) const {
  if (!is_here_) return;
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
  if (sample_.time_ns > before_.time_ns)
    spin_rad_s = 1e9 / static_cast<double>(sample_.time_ns - before_.time_ns) *
                 rotation_vector(sample_.orientation * before_.orientation.conjugate());
  for (const scene::ToolSphere& part : hand_.tool) {
    const Eigen::Vector3d arm_m = sample_.orientation * part.position_m;
    contact::ToolSphereMotion& sphere = spheres.emplace_back();
    sphere.position_m = sphere.position_before_m = sample_.position_m + arm_m;
    sphere.velocity_m_s = sample_.velocity_m_s + spin_rad_s.cross(arm_m);
    sphere.radius_m = part.radius_m;
    sphere.spin_rad_s = spin_rad_s;
    sphere.slip_speed_m_s = hand_.tool_slip_speed_m_s;
    sphere.hand = number_;
  }
}

}  // namespace stillgrid::dynamics
