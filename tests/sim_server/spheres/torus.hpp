#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "sim_server/spheres/ball.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {

/// A torus about z whose distance is known everywhere.
inline constexpr double kTorusRing_m = 0.10, kTorusTube_m = 0.03;

/// Inscribed balls, evenly along the ring.
inline std::vector<Ball> torus_balls(int count) {
  std::vector<Ball> balls;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * M_PI * i / count;
    balls.push_back(
        {{kTorusRing_m * std::cos(angle), kTorusRing_m * std::sin(angle), 0.0}, kTorusTube_m});
  }
  return balls;
}

inline double torus_distance_m(const Eigen::Vector3d& point_m) {
  return std::hypot(point_m.head<2>().norm() - kTorusRing_m, point_m.z()) - kTorusTube_m;
}

/// Samples along a spiral that winds round the tube, evenly but for the tube's inside being
/// shorter.
inline SurfaceSamples torus_samples(std::size_t count) {
  constexpr double kGolden = 1.61803398874989484820;
  SurfaceSamples samples;
  for (std::size_t i = 0; i < count; ++i) {
    const double along = 2.0 * M_PI * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    const double round = 2.0 * M_PI * std::fmod(kGolden * static_cast<double>(i), 1.0);
    const Eigen::Vector3d outward(std::cos(along), std::sin(along), 0.0);
    samples.normals.push_back(std::cos(round) * outward +
                              std::sin(round) * Eigen::Vector3d::UnitZ());
    samples.points_m.push_back(kTorusRing_m * outward + kTorusTube_m * samples.normals.back());
  }
  return samples;
}

}  // namespace stillgrid::spheres
