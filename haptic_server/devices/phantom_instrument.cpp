#include "haptic_server/devices/phantom_instrument.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace stillgrid::devices {
namespace {

/// 1 + e . u of a shaft: twice the squared cosine of half the angle from -z.
double nearness_to_down(const Eigen::Vector3d& shaft) noexcept {
  return 1.0 - shaft.z();
}

/// Generated paths repeat themselves from the third period on.
std::vector<double> times_to_look_at_s(const Path& path) {
  std::vector<double> times_s;
  if (path.kind != PathKind::kRecorded) {
    for (int n = 0; n <= 3000; ++n) times_s.push_back(1e-3 * n * path.period_s);
    return times_s;
  }
  const std::vector<double>& knots_s = path.recorded.knot_time_s;
  for (std::size_t k = 0; k + 1 < knots_s.size(); ++k)
    for (int n = 0; n < 8; ++n)
      times_s.push_back(knots_s[k] + 0.125 * n * (knots_s[k + 1] - knots_s[k]));
  times_s.push_back(knots_s.back());
  return times_s;
}

}  // namespace

Instrument place_instrument(const Instrument& before, const Eigen::Vector3d& handle_m,
                            const Eigen::Vector3d& pivot_m) noexcept {
  const Eigen::Vector3d way_m = pivot_m - handle_m;
  const double distance_m = way_m.norm();
  const Eigen::Vector3d shaft = distance_m > 0.0 ? way_m / distance_m : before.shaft;
  return {handle_m, shaft, distance_m};
}

Eigen::Quaterniond orientation_of(const Instrument& instrument) noexcept {
  const Eigen::Vector3d& u = instrument.shaft;
  constexpr double kStraightUp = 1e-12;  // of 1 + e . u: rounding has the better of the axis
  const double w = nearness_to_down(u);
  if (w < kStraightUp) return {0.0, 1.0, 0.0, 0.0};
  return Eigen::Quaterniond(w, u.y(), -u.x(), 0.0).normalized();  // 1 + e . u and e x u
}

// The handle at velocity v turns the instrument at w = v x u / d + s u. The first part keeps the
// shaft through the pivot. The roll s of the shortest rotation q = (1 + e . u, e x u) is, by
// w = 2 q' q*, s = (e . (u' x u)) / (1 + e . u) with u' x u = -v x u / d. Then
//   F . v + T . w = (F + u x T / d - (u . T) u x e / (d (1 + e . u))) . v.
Eigen::Vector3d force_at_handle_N(const Instrument& instrument, const Eigen::Vector3d& force_N,
                                  const Eigen::Vector3d& torque_N_m) noexcept {
  constexpr double kLeastNearness = 1e-3;  // keeps the roll's part bounded, 2.6 degrees from up
  const Eigen::Vector3d& u = instrument.shaft;
  const double roll_torque_N_m = u.dot(torque_N_m) / std::max(nearness_to_down(u), kLeastNearness);
  const Eigen::Vector3d cross_torque_N_m = torque_N_m + roll_torque_N_m * Eigen::Vector3d::UnitZ();
  return force_N + u.cross(cross_torque_N_m) / std::max(instrument.distance_m, kLeastInstrument_m);
}

bool holds_instrument(const Eigen::Vector3d& handle_m, const Eigen::Vector3d& pivot_m) noexcept {
  const Eigen::Vector3d above_m = handle_m - pivot_m;
  return above_m.norm() >= kLeastInstrument_m && above_m.z() >= 0.0;
}

std::optional<Eigen::Vector3d> unfit_point_m(const Path& path, const Eigen::Vector3d& pivot_m) {
  for (const double time_s : times_to_look_at_s(path)) {
    const Eigen::Vector3d point_m = path_at(path, time_s).position_m;
    if (!holds_instrument(point_m, pivot_m)) return point_m;
  }
  return std::nullopt;
}

}  // namespace stillgrid::devices
