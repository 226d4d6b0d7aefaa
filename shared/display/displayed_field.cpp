#include "shared/display/displayed_field.hpp"

#include <array>

#include "shared/collision/field_history.hpp"

namespace stillgrid::display {
namespace {

Eigen::Vector3d vector(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

Eigen::Vector4d quaternion(const proto::FieldState& state) {
  return Eigen::Map<const Eigen::Vector4f>(state.orientation_xyzw.data()).cast<double>();
}

/// Pre: xyzw is not zero.
Eigen::Matrix3d rotation(const Eigen::Vector4d& xyzw) {
  return Eigen::Quaterniond(Eigen::Vector4d(xyzw.normalized())).toRotationMatrix();
}

}  // namespace

DisplayedField displayed(const proto::FieldState& state) noexcept {
  return {vector(state.position_m), rotation(quaternion(state)), vector(state.velocity_m_s),
          vector(state.angular_velocity_rad_s)};
}

std::optional<DisplayedField> displayed(const proto::FieldRecord& record,
                                        const SnapshotWeights& weights) noexcept {
  // Half a turn apart two snapshots tell of no way between them.
  constexpr double kOpposite = 1e-3;
  const auto& [newest, before] = record.history;
  if (!collision::is_sound(newest)) return std::nullopt;
  const double alpha = weights.alpha;
  if (alpha == 1.0) return displayed(newest);
  if (!collision::is_sound(before)) return std::nullopt;
  const auto between = [alpha](const auto& a, const auto& b) {
    return Eigen::Vector3d(alpha * vector(a) + (1.0 - alpha) * vector(b));
  };
  const Eigen::Vector4d turn = quaternion(newest), was = quaternion(before);
  // Quaternions of one turn may differ by their sign.
  const Eigen::Vector4d sum =
      alpha * turn + (turn.dot(was) < 0.0 ? alpha - 1.0 : 1.0 - alpha) * was;
  return DisplayedField{between(newest.position_m, before.position_m),
                        rotation(sum.norm() > kOpposite ? sum : turn),
                        between(newest.velocity_m_s, before.velocity_m_s),
                        between(newest.angular_velocity_rad_s, before.angular_velocity_rad_s)};
}

}  // namespace stillgrid::display
