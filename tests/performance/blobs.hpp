#pragma once

#include <span>
#include <vector>

#include "sim_server/spheres/ball_grid.hpp"

namespace stillgrid::performance {

/// A body as blobs: balls whose distances melt into one smooth distance
///
///   s(x) = -softness * ln sum_i exp(-(|x - c_i| - R_i) / softness),
///
/// the surface of which is s = 0. A weight of a blob is a change of its radius by softness * ln
/// weight, so a set of blobs is a set of balls and one softness. Terms fade out, twice continuously
/// differentiable, between kFadeFrom and kFadeTo softnesses beyond the largest tool's radius.
/// Lengths in metres, body's own frame.
/// [Davanne 2002, "Interaction model", first method; Blinn, ACM Trans. Graphics 1(3), 1982]
struct BlobBody {
  std::vector<spheres::Ball> balls;
  spheres::BallGrid grid;  // of these balls, reaching to where they have faded out
  double softness_m = 0.0;
  double tool_radius_m = 0.0;  // of the largest tool
};

inline constexpr double kFadeFrom = 4.0;
inline constexpr double kFadeTo = 8.0;

/// Pre: softness_m > 0, tool_radius_m >= 0.
[[nodiscard]] BlobBody make_blob_body(std::span<const spheres::Ball> balls, double softness_m,
                                      double tool_radius_m);

/// The smooth distance at a point, and its gradient: never longer than 1 where no term fades, for
/// it is a mean of unit vectors.
struct BlobSample {
  double distance_m = 0.0;  // negative inside; infinite out of all balls' reach
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// Realtime: balls_near(), then an exponential and a root per ball near; never allocates, locks or
/// throws. NaN is out of reach.
[[nodiscard]] BlobSample sample_blobs(const BlobBody& body,
                                      const Eigen::Vector3d& point_m) noexcept;

/// The force on a tool sphere, still, for a stiffness of 1 N/m: minus the gradient of the energy
/// max(0, tool radius - s)^2 / 2. In N for each N/m, that is in metres. Continuous; over any closed
/// path its work is zero.
/// Realtime: as sample_blobs(). Pre: tool_radius_m <= body.tool_radius_m.
[[nodiscard]] Eigen::Vector3d unit_blob_force_m(const BlobBody& body, double tool_radius_m,
                                                const Eigen::Vector3d& tool_m) noexcept;

}  // namespace stillgrid::performance
