#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace stillgrid::collision {

/// The half-space that touches a surface near a proxy, on the side of the proxy.
struct HalfSpace {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, towards the proxy
  double gap_m = 0.0;  // distance between the proxy's sphere and the surface; negative: overlap
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();  // displacement of the surface until the goal
  double depth_m = 0.0;   // overlap with the device's sphere; negative: distance
  double push_m = 0.0;    // part of the way between device and proxy that this half-space takes
  bool lets_out = false;  // the proxy is deeper in than a tick lets it out
};

/// Computes depths and pushes of half-spaces that have moved. goal_m: the device's place, seen from
/// the proxy. Returns the proxy's displacement, m. The proxy ends at the place outside all
/// half-spaces that is nearest to the device. Each half-space pushes by its own depth at most.
/// Walls of a corner push as vectors, faces of one plane as one. Realtime: yes.
///
/// Source: the quadratic program of the god-object [Zilles, Salisbury 1995], solved as least
/// squares with bounds [Stark, Parker 1995].
[[nodiscard]] Eigen::Vector3d push_out(const Eigen::Vector3d& goal_m,
                                       std::span<HalfSpace> spaces) noexcept;

/// Speed at which a surface that appears lets a proxy out, and one that goes lets it in, m/s.
inline constexpr double kLeaving_m_s = 20e-3;

/// Half-spaces are laid so often in a tick.
inline constexpr int kLayings = 4;

/// Returns the longest displacement of a proxy after a laying, m, relative to the surface that
/// pushes it most. device_moved_m: that of the device. A proxy that lost its hold follows the
/// device by an eighth of its radius a tick.
[[nodiscard]] inline double longest_move_m(double radius_m, double device_moved_m) {
  return device_moved_m + 0.125 / kLayings * radius_m;
}

/// Returns the half-space that pushes most, or null.
[[nodiscard]] inline const HalfSpace* most_pushed(std::span<const HalfSpace> spaces) {
  const auto most = std::ranges::max_element(spaces, {}, &HalfSpace::push_m);
  return most == spaces.end() || !(most->push_m > 0.0) ? nullptr : &*most;
}

/// A tick of a tool's sphere.
struct DeviceMove {
  Eigen::Vector3d from_m, to_m;
  double radius_m = 0.0, tick_s = 0.0;
  double longest_m = std::numeric_limits<double>::infinity();  // displacement of the proxy
};

/// A part of a tick, as shares of it.
struct TickPart {
  double from = 0.0, to = 1.0;
  [[nodiscard]] double share() const { return to - from; }
};

/// Bounds the overlaps of a laying. A body that appears around a proxy lets the proxy out at
/// 20 mm/s, and the force grows evenly. A surface that turns or accelerates overlaps by a part of
/// its motion relative to the device. device_moved_m: displacement of the device.
inline void bound_overlaps(std::span<HalfSpace> spaces, const Eigen::Vector3d& device_moved_m,
                           double tick_s) {
  constexpr double kTurning = 0.25;
  for (HalfSpace& space : spaces) {
    const double slack_m = kTurning * (device_moved_m - space.moved_m).norm();
    const double bound_m = -(kLeaving_m_s / kLayings * tick_s + slack_m);
    space.lets_out = space.gap_m < bound_m;
    space.gap_m = std::max(space.gap_m, bound_m);
  }
}

/// Returns whether a surface in reach passes the device by more than an eighth of the radius.
/// The device moves by device_moved_m meanwhile.
[[nodiscard]] inline bool passes_by(std::span<const HalfSpace> spaces,
                                    const Eigen::Vector3d& device_moved_m, double radius_m) {
  return std::ranges::any_of(spaces, [&](const HalfSpace& space) {
    return (device_moved_m - space.moved_m).norm() > std::max(0.125 * radius_m, space.gap_m);
  });
}

/// Moves a proxy along with the device and returns its place, m. A laying, lay(proxy_m, part),
/// returns the half-spaces of a sphere there. They are those at the start of the part, with the
/// displacements of their surfaces during it. Afterwards they hold the depths and pushes of the
/// last laying. Device and surfaces go through the tick at once, or by thirds if a surface goes by.
/// The place is device.to_m itself if no surface holds the proxy back. The result depends on
/// relative motion alone. Realtime: as lay.
template <class Lay>
Eigen::Vector3d follow(Eigen::Vector3d proxy_m, const DeviceMove& device, const Lay& lay) {
  constexpr double kStill_m = 1e-8;
  const Eigen::Vector3d tick_m = device.to_m - device.from_m;
  double parts = 1.0;
  for (int k = 0; k < kLayings; ++k) {
    TickPart part{std::min(k / parts, 1.0), std::min((k + 1) / parts, 1.0)};
    const std::span<HalfSpace> spaces = lay(proxy_m, part);
    if (k == 0 && passes_by(spaces, tick_m, device.radius_m)) {
      parts = kLayings - 1;
      part.to = 1.0 / parts;
      for (HalfSpace& space : spaces) space.moved_m *= part.to;
    }
    const Eigen::Vector3d moved_m = part.share() * tick_m;
    const Eigen::Vector3d device_m = device.to_m - (1.0 - part.to) * tick_m;
    bound_overlaps(spaces, moved_m, device.tick_s);
    const Eigen::Vector3d goal_m = device_m - proxy_m;
    const Eigen::Vector3d move_m = push_out(goal_m, spaces);
    const HalfSpace* const most = most_pushed(spaces);
    const Eigen::Vector3d carried_m = most == nullptr ? moved_m : most->moved_m;
    const Eigen::Vector3d own_m = move_m - carried_m;
    const double longest_m = std::min(
        device.longest_m / kLayings, longest_move_m(device.radius_m, (moved_m - carried_m).norm()));
    const double length_m = own_m.norm();
    if (!std::isfinite(length_m)) return device.to_m;
    if (move_m == goal_m && length_m <= longest_m)
      proxy_m = device_m;
    else
      proxy_m += carried_m + std::min(1.0, longest_m / std::max(length_m, longest_m)) * own_m;
    if (part.to == 1.0 && (proxy_m == device.to_m || length_m < kStill_m)) break;
  }
  return proxy_m;
}

/// Friction of a proxy that sticks: a spring with a damper across the normal, from where it last
/// stuck.
struct StickingFriction {
  /// A tick of the tool relative to the touched surface.
  struct Pull {
    Eigen::Vector3d moved_m, velocity_m_s, normal;
    double stiffness_N_per_m = 0.0, damping_N_s_per_m = 0.0, limit_N = 0.0;
  };
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();

  /// Stretches the spring by a tick and returns the force on the tool. The spring slides where
  /// the force reaches its limit [Hayward, Armstrong 2000]. Pre: stiffness > 0. Realtime: yes.
  [[nodiscard]] Eigen::Vector3d force_N(const Pull& pull) noexcept;
};

}  // namespace stillgrid::collision
