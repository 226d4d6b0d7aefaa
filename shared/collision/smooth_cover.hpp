#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "shared/collision/tool_proxy.hpp"

namespace stillgrid::collision {

/// A surface, seen from a proxy. Spheres of one body span its cover.
struct SeenSurface {
  int body = -1;                                     // -1: this is no sphere of a cover
  double radius_m = 0.0;                             // that of the sphere
  Eigen::Vector3d line_m = Eigen::Vector3d::Zero();  // the proxy's centre less that of the sphere
};

/// The surface that neighbouring spheres of a body span. A proxy slides on it without valleys if
/// their spacing is at most their radius. See docs/algorithms/tool_contact.md.
///
/// Thread: one. Realtime: wait-free, without allocation.
class SmoothCover {
 public:
  /// Replaces the half-spaces of spheres near a proxy by planes through the tops of their
  /// neighbours of the same body. Only the kMaxNear nearest take part. spaces[k] is that of
  /// surfaces[k].
  ///
  /// Source: moving least squares on point sets [Levin 1998], with a ridge that keeps the
  /// spheres' mean normal where neighbours span no plane.
  void lay(double proxy_radius_m, std::span<const SeenSurface> surfaces,
           std::span<HalfSpace> spaces) noexcept;
  /// Shares each push of a plane among the spheres that span it. The sum of the pushes' vectors
  /// and that of their energies stay. Pre: lay(), then push_out().
  void share(std::span<HalfSpace> spaces) const noexcept;

  /// Returns the longest gap between a proxy and a sphere that takes part, m. It is twice the gap
  /// over the next sphere if spheres are a radius apart, and margin_m() at most.
  [[nodiscard]] static double neighbour_gap_m(double proxy_radius_m, double radius_m) noexcept;
  [[nodiscard]] static constexpr double margin_m(double proxy_radius_m) { return proxy_radius_m; }

  static constexpr std::size_t kMaxNear = 32;

 private:
  struct Near {
    std::size_t index;  // among the half-spaces
    double closeness;   // 1: touches; 0: out of reach, or as far as the nearest that is left out
    Eigen::Vector3d normal;
  };
  void find_near(double proxy_radius_m, std::span<const SeenSurface> surfaces,
                 std::span<const HalfSpace> spaces) noexcept;

  std::array<Near, kMaxNear> near_;
  std::size_t count_ = 0;
  std::array<std::array<double, kMaxNear>, kMaxNear> weights_;  // row i: shares in plane i, sum 1
};

}  // namespace stillgrid::collision
