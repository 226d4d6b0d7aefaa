// The law of contacts at an instant, for methods that integrate it.
#include <algorithm>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/implicit_contacts.hpp"

namespace stillgrid::dynamics {
namespace {

/// Of the spring: with less damping a slider would move its spring at any velocity.
constexpr double kLeastDamping_s = 1e-5;

}  // namespace

void ImplicitContacts::write_stretches(Eigen::Ref<Eigen::Matrix3Xd> stretches_m) const {
  for (std::size_t k = 0; k < touches_.size(); ++k)
    stretches_m.col(static_cast<Eigen::Index>(k)) = touches_[k].stretch_m;
}

void ImplicitContacts::evaluate_instant(const ImplicitPoses& poses, const Motions& velocities,
                                        const Eigen::Ref<const Eigen::Matrix3Xd>& stretches_m,
                                        Eigen::Ref<Eigen::Matrix3Xd> rates_m_s,
                                        EnergyLosses& powers) {
  move(poses);
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    touches_[k].stretch_m = stretches_m.col(column);
    evaluate_instant(touches_[k], couplings_[k], poses, velocities, rates_m_s.col(column), powers);
  }
}

void ImplicitContacts::evaluate_instant(Touch& touch, Coupling& coupling,
                                        const ImplicitPoses& poses, const Motions& velocities,
                                        Eigen::Ref<Eigen::Vector3d> rate_m_s,
                                        EnergyLosses& powers) const {
  Line line = line_of(touch);
  const bool is_plane = touch.field < 0 && touch.sphere_b < 0;
  line.normal = is_plane ? touch.normal : line.line_m.stableNormalized();
  const double depth_m = touch.radius_a_m + touch.radius_b_m - line.after_m;
  touch.scale = line.scale;
  touch.stiffness_root = line.stiffness_root;
  const double k = touch.scale * touch.stiffness_N_per_m;
  const double c = touch.scale * touch.damping_N_s_per_m;
  const double c_along = std::max(c, kLeastDamping_s * k);
  coupling.is_active = depth_m > 0.0;
  coupling.impulse_N_s.setZero();
  touch.push_impulse_N_s = 0.0;
  touch.friction_impulse_N_s.setZero();
  touch.stretch_after_m.setZero();
  rate_m_s.setZero();
  if (!coupling.is_active) {
    if (k > 0.0) rate_m_s = -k / c_along * touch.stretch_m;
    return;
  }
  set_arms(touch, coupling, line, poses, Moment::kEnd);
  const Eigen::Vector3d velocity = relative_velocity(coupling, velocities, poses);
  const double deepens_m_s = std::max(0.0, -line.normal.dot(velocity));
  const double push_N = k * depth_m + c * deepens_m_s, limit_N = touch.friction * push_N;
  const Eigen::Vector3d slip = across(velocity, line.normal);
  const Eigen::Vector3d stretch = across(touch.stretch_m / touch.stiffness_root, line.normal);
  const bool holds = touch.viscous_s_per_m == 0.0;
  Eigen::Vector3d drag_N = holds ? Eigen::Vector3d(k * stretch + c_along * slip)
                                 : Eigen::Vector3d(limit_N * touch.viscous_s_per_m * slip);
  Eigen::Vector3d stretches_m_s = holds && k > 0.0 ? slip : Eigen::Vector3d::Zero();
  if (const double size_N = drag_N.norm(); size_N > limit_N) {
    drag_N *= limit_N / size_N;
    if (holds && k > 0.0) stretches_m_s = (drag_N - k * stretch) / c_along;
  }
  touch.push_impulse_N_s = poses.step_s() * push_N;
  touch.friction_impulse_N_s = -poses.step_s() * drag_N;
  if (holds) touch.stretch_after_m = stretch;
  coupling.impulse_N_s = push_N * line.normal - drag_N;
  const auto spin_rad_s = [&](const ActedPoint& point) {
    return point.rigid < 0 ? 0.0
                           : line.normal.dot(velocities[poses.spin(at(point.rigid))].vector());
  };
  const double turns_rad_s = 0.5 * (spin_rad_s(coupling.a) + spin_rad_s(coupling.b));
  rate_m_s = touch.stiffness_root * (stretches_m_s + turns_rad_s * line.normal.cross(stretch));
  if (is_driven(coupling.a, description_) && is_driven(coupling.b, description_))
    return;  // no energy of the scene
  powers.contact_damping_J += c * deepens_m_s * deepens_m_s;
  powers.friction_J += drag_N.dot(slip) - k * stretch.dot(stretches_m_s);
}

}  // namespace stillgrid::dynamics
