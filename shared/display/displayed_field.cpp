#include "shared/display/displayed_field.hpp"

#include <algorithm>
#include <cstddef>

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

Eigen::Matrix3d turned(const Eigen::Vector3d& turn_rad, const Eigen::Matrix3d& orientation) {
  const double angle_rad = turn_rad.norm();
  // Written so that a NaN does not pass.
  if (!(angle_rad > 1e-12 && angle_rad <= proto::kLargestNumber)) return orientation;
  return Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad) * orientation;
}

/// What snapshots tell, by their weights.
struct Sum {
  DisplayedField field;
  Eigen::Vector4d turn = Eigen::Vector4d::Zero();
  Eigen::Vector3d led_rad = Eigen::Vector3d::Zero();

  /// newest: quaternions of one turn may differ by their sign.
  void add(const proto::FieldState& snapshot, double weight, double velocity_s,
           const Eigen::Vector4d& newest) {
    const Eigen::Vector3d velocity_m_s = vector(snapshot.velocity_m_s),
                          spin_rad_s = vector(snapshot.angular_velocity_rad_s);
    const Eigen::Vector4d own = quaternion(snapshot);
    field.position_m += weight * vector(snapshot.position_m) + velocity_s * velocity_m_s;
    field.velocity_m_s += weight * velocity_m_s;
    field.angular_velocity_rad_s += weight * spin_rad_s;
    turn += (own.dot(newest) < 0.0 ? -weight : weight) * own;
    led_rad += velocity_s * spin_rad_s;
  }
};

}  // namespace

DisplayedField displayed(const proto::FieldState& state) noexcept {
  return {vector(state.position_m), rotation(quaternion(state)), vector(state.velocity_m_s),
          vector(state.angular_velocity_rad_s)};
}

std::optional<DisplayedField> displayed(const proto::FieldRecord& record,
                                        const SnapshotWeights& weights) noexcept {
  // Half a turn apart two snapshots tell of no way between them.
  constexpr double kOpposite = 1e-3;
  if (!collision::is_sound(record.history[0])) return std::nullopt;
  const Eigen::Vector4d newest = quaternion(record.history[0]);
  Sum sum;
  for (std::size_t i = 0; i < record.history.size(); ++i) {
    const double velocity_s = i < weights.velocity_s.size() ? weights.velocity_s[i] : 0.0;
    if (weights.position[i] == 0.0 && velocity_s == 0.0) continue;
    if (!collision::is_sound(record.history[i])) return std::nullopt;
    sum.add(record.history[i], weights.position[i], velocity_s, newest);
  }
  const double prediction_s =
      weights.prediction_s - (record.response != 0 ? weights.compliance_lag_s : 0.0);
  if (prediction_s != 0.0) {
    proto::FieldState predicted = record.history[0];
    predicted.velocity_m_s = record.predicted_velocity_m_s;
    predicted.angular_velocity_rad_s = record.predicted_angular_velocity_rad_s;
    if (!collision::is_sound(predicted)) return std::nullopt;
    sum.field.position_m += prediction_s * vector(predicted.velocity_m_s);
    sum.led_rad += prediction_s * vector(predicted.angular_velocity_rad_s);
  }
  sum.field.orientation =
      turned(sum.led_rad, rotation(sum.turn.norm() > kOpposite ? sum.turn : newest));
  return sum.field;
}

DisplayedField led_on(const DisplayedField& shown, const proto::FieldRecord& record) noexcept {
  return {shown.position_m, shown.orientation, vector(record.predicted_velocity_m_s),
          vector(record.predicted_angular_velocity_rad_s)};
}

std::optional<FieldResponse> response_of(const collision::GridView& grid,
                                         const proto::FieldRecord& record,
                                         double largest_response) noexcept {
  // Its second one is behind the first.
  if (record.response == 0 || record.response >= grid.response_count) return std::nullopt;
  const auto load = [&](std::uint32_t index) {
    const proto::SphereResponse response = collision::load_response(grid, index);
    return ResponseMatrix(Eigen::Map<const ResponseMatrix>(response.modes.front().data()));
  };
  const FieldResponse response{load(record.response - 1), load(record.response)};
  // Written so that a NaN does not pass.
  if (!(static_cast<double>(response.origin.norm()) <= largest_response) ||
      !(static_cast<double>(response.turn.norm()) <= proto::kLargestNumber))
    return std::nullopt;
  return response;
}

DisplayedField given_way(const DisplayedField& shown, const FieldResponse& response,
                         const ModeDisplacements& displacements) noexcept {
  DisplayedField moved = shown;
  moved.position_m += response.origin.cast<double>() * displacements;
  moved.orientation = turned(response.turn.cast<double>() * displacements, shown.orientation);
  return moved;
}

}  // namespace stillgrid::display
