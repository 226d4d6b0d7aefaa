#include "shared/publication/moving_fields.hpp"

namespace stillgrid::publication {
namespace {

std::array<float, 3> three_floats(const Eigen::Vector3d& v) noexcept {
  const Eigen::Vector3f f = v.cast<float>();
  return {f.x(), f.y(), f.z()};
}

}  // namespace

proto::FieldState field_state(const Eigen::Vector3d& position_m,
                              const Eigen::Quaterniond& orientation,
                              const Eigen::Vector3d& velocity_m_s,
                              const Eigen::Vector3d& angular_velocity_rad_s) noexcept {
  const Eigen::Vector4f turn = orientation.coeffs().cast<float>();
  return {.position_m = three_floats(position_m),
          .orientation_xyzw = {turn.x(), turn.y(), turn.z(), turn.w()},
          .velocity_m_s = three_floats(velocity_m_s),
          .angular_velocity_rad_s = three_floats(angular_velocity_rad_s),
          .reserved = 0.0F};
}

}  // namespace stillgrid::publication
