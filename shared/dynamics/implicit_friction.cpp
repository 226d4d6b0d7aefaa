// Friction of contacts in an implicit step.
#include <algorithm>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/implicit_contacts.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kShortestStretch_m = 1e-12;  // stretches below it have no direction

}  // namespace

/// Turns the stretch of friction with the normal, and about it with both sides. Keeps its length.
void ImplicitContacts::turn_stretch(Touch& touch, const Coupling& coupling,
                                    const ImplicitPoses& poses) {
  const Eigen::Vector3d normal = touch.line_m.stableNormalized();
  const auto spin_rad_s = [&](const ActedPoint& point) {
    return point.rigid < 0
               ? 0.0
               : normal.dot(poses.from().angular_velocity_rad_s[at(point.rigid)].vector());
  };
  const double turn_rad = 0.5 * poses.step_s() * (spin_rad_s(coupling.a) + spin_rad_s(coupling.b));
  const double length = touch.stretch_m.norm();
  const Eigen::Vector3d tilted = across(touch.stretch_m, normal);
  const double is = tilted.norm();
  touch.stretch_m.setZero();
  if (is > kShortestStretch_m)
    touch.stretch_m = std::min(2.0, length / is) * (rotation_by(turn_rad * normal) * tilted);
}

void ImplicitContacts::turn_stretches(const ImplicitPoses& poses) {
  for (std::size_t k = 0; k < touches_.size(); ++k) turn_stretch(touches_[k], couplings_[k], poses);
}

/// Linearises both sides of aim |slip| = slip, where friction is at its limit.
void ImplicitContacts::aim_friction(const ImplicitPoses& poses, const Motions& change) {
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    Touch& touch = touches_[k];
    if (touch.limit_impulse_N_s == 0.0) continue;
    const Eigen::Vector3d more =
        touch.hold_slope_kg * relative_velocity(couplings_[k], change, poses);
    const double size = std::max(touch.asked_impulse_N_s.norm(), touch.limit_impulse_N_s);
    touch.next_aim = (touch.asked_impulse_N_s + more) / size;
    if (size > touch.limit_impulse_N_s)
      touch.next_aim -= touch.asked_impulse_N_s.dot(more) / (size * size) * touch.aim;
  }
}

void ImplicitContacts::turn_aims(double share) {
  for (Touch& touch : touches_) {
    touch.aim += share * (touch.next_aim - touch.aim);
    touch.aim /= std::max(1.0, touch.aim.norm());
  }
}

void ImplicitContacts::limit_friction() {
  for (Touch& touch : touches_) touch.limit_impulse_N_s = touch.friction * touch.push_impulse_N_s;
}

/// Along a slip at Coulomb's limit friction does not grow. The slope has no part along it, once the
/// aim agrees with the slip. An aim of its own keeps Newton's method from jumping between opposite
/// slips [Chan, Golub, Mulet 1999].
void ImplicitContacts::rub(Touch& touch, Coupling& coupling, const Eigen::Vector3d& normal,
                           const Eigen::Vector3d& velocity, double h) const {
  const Eigen::Vector3d slip = across(velocity, normal);
  const double most = touch.limit_impulse_N_s;
  const bool holds = touch.viscous_s_per_m == 0.0;
  const double k = touch.scale * touch.stiffness_N_per_m;
  const double c = touch.scale * touch.damping_N_s_per_m;
  double slope = holds ? h * (h * k + c) : most * touch.viscous_s_per_m;
  const Eigen::Vector3d stretch = across(touch.stretch_m / touch.stiffness_root, normal);
  Eigen::Vector3d asked = slope * slip;
  if (holds) asked += h * k * stretch;
  const double size = asked.norm();
  Eigen::Matrix3d plane = Eigen::Matrix3d::Identity() - normal * normal.transpose();
  touch.hold_slope_kg = slope;
  touch.asked_impulse_N_s = asked;
  if (size > most) {
    const Eigen::Vector3d along = asked / size, aim = across(touch.aim, normal);
    plane -= 0.5 * (along * aim.transpose() + aim * along.transpose());
    asked *= most / size;
    slope *= most / size;
  }
  touch.friction_impulse_N_s = -asked;
  coupling.impulse_N_s -= asked;
  coupling.slope_kg += slope * plane;
  if (holds && k > 0.0) touch.stretch_after_m = (asked + c * stretch) / (h * k + c);
}

/// Friction takes the work of its force less that of its spring.
void ImplicitContacts::add_losses(const ImplicitPoses& poses, const Motions& velocities,
                                  EnergyLosses& losses) const {
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    const Touch& touch = touches_[k];
    if (!couplings_[k].is_active) continue;
    const Line line = line_of(touch);
    const double radii = touch.radius_a_m + touch.radius_b_m;
    const double deepens_m =
        std::max(0.0, radii - line.after_m) - std::max(0.0, radii - line.before_m);
    if (deepens_m > 0.0)
      losses.contact_damping_J +=
          touch.scale * touch.damping_N_s_per_m / poses.step_s() * deepens_m * deepens_m;
    const Eigen::Vector3d slip = relative_velocity(couplings_[k], velocities, poses);
    const Eigen::Vector3d more = touch.stretch_after_m - across(touch.stretch_m, line.normal);
    losses.friction_J -= touch.friction_impulse_N_s.dot(slip) +
                         touch.stiffness_N_per_m * touch.stretch_after_m.dot(more);
  }
}

}  // namespace stillgrid::dynamics
