#include "sim_server/dynamics/tool_motion.hpp"

#include <cmath>
#include <numbers>

namespace stillgrid {

void ToolMotion::place(const ToolSample& sample) {
  const bool known = over_step_.size() == spheres_.size();
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
  if (known && sample.time_ns > last_sample_.time_ns) {
    const Eigen::AngleAxisd turn(sample.orientation * last_sample_.orientation.conjugate());
    // The shorter way round.
    const double angle_rad = std::remainder(turn.angle(), 2.0 * std::numbers::pi);
    spin_rad_s =
        angle_rad * 1e9 / static_cast<double>(sample.time_ns - last_sample_.time_ns) * turn.axis();
  }
  last_sample_ = sample;
  over_step_.resize(spheres_.size());
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    const Eigen::Vector3d centre_m =
        sample.position_m + sample.orientation * spheres_[i].position_m;
    over_step_[i] = {centre_m, sample.velocity_m_s + spin_rad_s.cross(centre_m - sample.position_m),
                     known ? over_step_[i].position_m : centre_m, spheres_[i].radius_m, spin_rad_s};
  }
}

const std::vector<ToolSphereMotion>& ToolMotion::over(double start, double end) {
  over_part_ = over_step_;
  for (ToolSphereMotion& sphere : over_part_) {
    const Eigen::Vector3d from_m = sphere.position_before_m;
    const Eigen::Vector3d move_m = sphere.position_m - from_m;
    if (end < 1.0) sphere.position_m = from_m + end * move_m;
    sphere.position_before_m = from_m + start * move_m;
  }
  return over_part_;
}

}  // namespace stillgrid
