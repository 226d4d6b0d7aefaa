#include "shared/collision/contact_law.hpp"

#include <algorithm>

namespace stillgrid::collision {
namespace {

double harmonic_mean(double a, double b) noexcept {
  return a + b > 0.0 ? 2.0 * a * b / (a + b) : 0.0;
}

}  // namespace

ContactMaterial pair_material(const ContactMaterial& a, const ContactMaterial& b) noexcept {
  return {.stiffness_N_per_m = harmonic_mean(a.stiffness_N_per_m, b.stiffness_N_per_m),
          .damping_N_s_per_m = harmonic_mean(a.damping_N_s_per_m, b.damping_N_s_per_m),
          .friction = std::min(a.friction, b.friction),
          .slip_speed_m_s = std::max(a.slip_speed_m_s, b.slip_speed_m_s)};
}

ContactMaterial tool_material(ContactMaterial touched, double tool_slip_speed_m_s) noexcept {
  touched.slip_speed_m_s = std::max(touched.slip_speed_m_s, tool_slip_speed_m_s);
  return touched;
}

double normal_force_N(const ContactMaterial& material, double depth_m,
                      double approach_speed_m_s) noexcept {
  if (!(depth_m > 0.0)) return 0.0;
  return material.stiffness_N_per_m * depth_m +
         material.damping_N_s_per_m * std::max(0.0, approach_speed_m_s);
}

Eigen::Vector3d friction_force_N(const ContactMaterial& material, double normal_force_N,
                                 const Eigen::Vector3d& slip_m_s) noexcept {
  const double scale_m_s = std::max(slip_m_s.norm(), material.slip_speed_m_s);
  return -material.friction * normal_force_N / scale_m_s * slip_m_s;
}

Eigen::Vector3d contact_force_N(const ContactMaterial& material, double depth_m,
                                const Eigen::Vector3d& normal,
                                const Eigen::Vector3d& relative_velocity_m_s) noexcept {
  const double separation_m_s = normal.dot(relative_velocity_m_s);
  const double normal_load_N = normal_force_N(material, depth_m, -separation_m_s);
  const Eigen::Vector3d slip_m_s = relative_velocity_m_s - separation_m_s * normal;
  return normal_load_N * normal + friction_force_N(material, normal_load_N, slip_m_s);
}

}  // namespace stillgrid::collision
