#pragma once

#include <span>
#include <vector>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/surface_samples.hpp"
#include "tests/performance/blobs.hpp"

namespace stillgrid::performance {

/// A place, and how far from the surface it lies.
struct DistanceTarget {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  double distance_m = 0.0;  // negative inside
};

/// What the smooth distance of a mesh's blobs should be: zero at each sample, and the distance of
/// the places half and one tool radius out of it along its normal.
/// Pre: tool_radius_m > 0, the samples are of that mesh.
[[nodiscard]] std::vector<DistanceTarget> distance_targets(const spheres::SurfaceSamples& surface,
                                                           const mesh::MeshDistance& mesh,
                                                           double tool_radius_m);

/// Melts a decomposition's balls into as many blobs, whose smooth distance follows the targets'.
///
/// Least squares of the differences in metres over all centres, radii and the softness, by
/// Levenberg and Marquardt's method from the balls as they are; softness begins at the depth of
/// their ripple over the targets, to which it is proportional at the best fit. The same input gives
/// the same blobs. A level of detail is a fit of that level's balls.
/// Pre: neither span empty, at least four targets a ball, tool_radius_m > 0, no target further from
/// the surface than tool_radius_m.
[[nodiscard]] BlobBody fit_blobs(std::span<const spheres::Ball> balls,
                                 std::span<const DistanceTarget> targets, double tool_radius_m);

/// How far the smooth distance is from the targets'.
struct BlobFit {
  double rms_m = 0.0;
  double max_m = 0.0;
};
[[nodiscard]] BlobFit blob_fit(const BlobBody& body, std::span<const DistanceTarget> targets);

/// Two-sided Hausdorff distance between the blobs' surface and the mesh, over the samples: from
/// each to the blobs' surface along their gradient, and from there back to the mesh; an upper bound
/// at these points. Samples out of all blobs' reach make it infinite.
[[nodiscard]] double blob_surface_error_m(const BlobBody& body,
                                          const spheres::SurfaceSamples& surface,
                                          const mesh::MeshDistance& mesh);

}  // namespace stillgrid::performance
