#include "haptic_server/devices/path.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace stillgrid::devices {
namespace {

/// A scalar and its derivative in time.
struct Rated {
  double value = 0.0;
  double rate_1_s = 0.0;
};

/// From zero to one and back within the duration, at rest at both ends; repeats.
Rated dip(double time_s, double duration_s) {
  const double frequency_rad_s = 2.0 * std::numbers::pi / duration_s;
  return {0.5 * (1.0 - std::cos(frequency_rad_s * time_s)),
          0.5 * frequency_rad_s * std::sin(frequency_rad_s * time_s)};
}

/// From zero to one within the duration, at rest at both ends; stays there.
Rated rise(double time_s, double duration_s) {
  if (time_s <= 0.0) return {0.0, 0.0};
  if (time_s >= duration_s) return {1.0, 0.0};
  return dip(time_s, 2.0 * duration_s);
}

/// The depth below the centre, as a share of the full depth.
Rated descent(const Path& path, double time_s) {
  switch (path.kind) {
    case PathKind::kPress:
      return dip(time_s, path.period_s);
    case PathKind::kTap: {
      const double dip_s = 0.25 * path.period_s;
      const double since_start_s = std::fmod(time_s, path.period_s);
      return since_start_s < dip_s ? dip(since_start_s, dip_s) : Rated{};
    }
    case PathKind::kStroke:
    case PathKind::kCircle:
      return rise(time_s, 0.5 * path.period_s);
    default:
      return {};
  }
}

/// The motion in the plane once the path is down. The amplitude grows from zero, so that it
/// starts at rest: r sin(wt) along x, and for a circle r cos(wt) along y.
MotionPoint sweep(const Path& path, double time_s) {
  const double frequency_rad_s = 2.0 * std::numbers::pi / path.period_s;
  const Rated growth = rise(time_s, path.period_s);
  const double sine = std::sin(frequency_rad_s * time_s);
  const double cosine = std::cos(frequency_rad_s * time_s);
  Eigen::Vector3d direction(sine, 0.0, 0.0);
  Eigen::Vector3d turn(frequency_rad_s * cosine, 0.0, 0.0);
  if (path.kind == PathKind::kCircle) {
    direction.y() = cosine;
    turn.y() = -frequency_rad_s * sine;
  }
  return {path.amplitude_m * growth.value * direction,
          path.amplitude_m * (growth.rate_1_s * direction + growth.value * turn)};
}

}  // namespace

std::optional<PathKind> path_kind(std::string_view name) noexcept {
  using namespace std::string_view_literals;
  constexpr std::array kKinds = {
      std::pair{"still"sv, PathKind::kStill}, std::pair{"press"sv, PathKind::kPress},
      std::pair{"stroke"sv, PathKind::kStroke}, std::pair{"tap"sv, PathKind::kTap},
      std::pair{"circle"sv, PathKind::kCircle}};
  for (const auto& [kind_name, kind] : kKinds) {
    if (kind_name == name) return kind;
  }
  return std::nullopt;
}

MotionPoint path_at(const Path& path, double time_s) noexcept {
  if (path.kind == PathKind::kRecorded) {
    CurveCursor cursor;
    return curve_at(path.recorded, time_s, cursor);
  }
  MotionPoint point{path.centre_m, Eigen::Vector3d::Zero()};
  if (time_s <= 0.0) return point;
  const Rated down = descent(path, time_s);
  point.position_m.z() -= path.depth_m * down.value;
  point.velocity_m_s.z() -= path.depth_m * down.rate_1_s;
  const double sweep_s = time_s - 0.5 * path.period_s;
  const bool sweeps = path.kind == PathKind::kStroke || path.kind == PathKind::kCircle;
  if (sweeps && sweep_s > 0.0) {
    const MotionPoint swept = sweep(path, sweep_s);
    point.position_m += swept.position_m;
    point.velocity_m_s += swept.velocity_m_s;
  }
  return point;
}

}  // namespace stillgrid::devices
