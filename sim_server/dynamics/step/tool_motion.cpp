#include "sim_server/dynamics/step/tool_motion.hpp"

#include <cmath>
#include <numbers>

namespace stillgrid::dynamics {

void ToolMotion::place(const ToolSample& sample, double step_s) {
  const bool known = is_here();
  start_sample_ = known ? sample_ : sample;
  from_ = 0.0;
  over_step_.resize(hand_.tool.size());
  for (contact::ToolSphereMotion& sphere : over_step_) sphere.position_before_m = sphere.position_m;
  end_at(sample);
  if (known) return;
  for (contact::ToolSphereMotion& sphere : over_step_)
    sphere.position_before_m = sphere.position_m - step_s * sample.velocity_m_s;
}

void ToolMotion::redirect(const ToolSample& sample, double from) {
  over_part_.clear();
  add_over(from, 1.0, over_part_);
  over_step_.swap(over_part_);
  from_ = from;
  end_at(sample);
}

void ToolMotion::end_at(const ToolSample& sample) {
  sample_ = sample;
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
  if (sample.time_ns > start_sample_.time_ns) {
    const Eigen::AngleAxisd turn(sample.orientation * start_sample_.orientation.conjugate());
    // The shorter way round.
    const double angle_rad = std::remainder(turn.angle(), 2.0 * std::numbers::pi);
    spin_rad_s =
        angle_rad * 1e9 / static_cast<double>(sample.time_ns - start_sample_.time_ns) * turn.axis();
  }
  for (std::size_t i = 0; i < over_step_.size(); ++i) {
    contact::ToolSphereMotion& sphere = over_step_[i];
    sphere.position_m = sample.position_m + sample.orientation * hand_.tool[i].position_m;
    sphere.velocity_m_s =
        sample.velocity_m_s + spin_rad_s.cross(sphere.position_m - sample.position_m);
    sphere.radius_m = hand_.tool[i].radius_m;
    sphere.spin_rad_s = spin_rad_s;
    sphere.slip_speed_m_s = hand_.tool_slip_speed_m_s;
    sphere.hand = number_;
  }
}

void ToolMotion::add_over(double start, double end,
                          std::vector<contact::ToolSphereMotion>& spheres) const {
  const auto way = [this](double share) { return (share - from_) / (1.0 - from_); };
  for (const contact::ToolSphereMotion& over_step : over_step_) {
    contact::ToolSphereMotion& sphere = spheres.emplace_back(over_step);
    const Eigen::Vector3d from_m = sphere.position_before_m;
    const Eigen::Vector3d move_m = sphere.position_m - from_m;
    if (end < 1.0) sphere.position_m = from_m + way(end) * move_m;
    sphere.position_before_m = from_m + way(start) * move_m;
  }
}

}  // namespace stillgrid::dynamics
