#pragma once

#include <vector>

#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid::spheres {

/// The paper's other way to spheres: even ones, by a parameter of the surface or the volume
/// [Davanne 2002, section 2]. More of them than decompose() needs, but all alike, so that the force
/// varies little over the body. Curves are threads, which bodies/kinds/thread.hpp covers.

/// Most balls of a sampling.
inline constexpr double kMaxSampledBalls = 2e5;

/// Balls under a surface that touch it from inside, any two at least spacing_m apart where they
/// touch, and none of the surface much farther than that from a ball's place. Smaller ones where
/// the solid is too thin for radius_m. Throws std::invalid_argument where they would be more than
/// kMaxSampledBalls, or none.
/// Pre: closed, as make_closed() leaves it; spacing_m, radius_m > 0.
[[nodiscard]] std::vector<Ball> surface_balls(const mesh::TriangleMesh& closed, double spacing_m,
                                              double radius_m);

/// Balls at the points of a cubic lattice that lie inside the solid. The lattice halves its cells
/// about the box's middle: a cube of edge n spacing_m holds n^3 points. Throws
/// std::invalid_argument where the box holds more than kMaxSampledBalls points, or the solid none.
/// Pre: as surface_balls().
[[nodiscard]] std::vector<Ball> volume_balls(const mesh::TriangleMesh& closed, double spacing_m,
                                             double radius_m);

/// Even balls under a surface that cannot be pushed through: each touches the surface from inside
/// and is as large as fits, so that all push from the medial axis; about spacing_m apart where they
/// are three of it in size, farther where they are larger, so that a tool touches about as many
/// everywhere.
///
/// A tool sphere of at least twice spacing_m in radius, pressed along the inward normal from
/// spacing_m deep until its centre has gone kFirmShare of the way from the surface to the medial
/// axis, is pushed outward at every depth, wherever a ball of spacing_m fits under the surface
/// (docs/algorithms/sphere_decomposition.md). For bodies that do not deform: a ball does not follow
/// a surface that it is larger than. Throws as surface_balls(). Pre: as surface_balls().
[[nodiscard]] std::vector<Ball> firm_surface_balls(const mesh::TriangleMesh& closed,
                                                   double spacing_m);

/// volume_balls() of kVolumeRadius spacings that cannot be pushed through, as firm_surface_balls():
/// those deeper inside grow to kFirmGrowth of their depth, so that the inner ones outweigh the
/// outer. Throws and Pre: as volume_balls().
[[nodiscard]] std::vector<Ball> firm_volume_balls(const mesh::TriangleMesh& closed,
                                                  double spacing_m);

/// Balls of radius_m on the surface itself, kShellSpacing radii apart at least. No place of the
/// surface is farther than about radius_m from the centre of one. Throws as surface_balls(). Pre:
/// the mesh has an area, open or not; radius_m > 0.
[[nodiscard]] std::vector<Ball> shell_balls(const mesh::TriangleMesh& mesh, double radius_m);
inline constexpr double kShellSpacing = 0.75;

/// To where firm balls push outward, from the surface (0) to the medial axis (1).
inline constexpr double kFirmShare = 0.3;
/// Radius of a ball deep inside, over its depth.
inline constexpr double kFirmGrowth = 0.75;
/// Of its depth, that a ball inside is at most apart from the next, or a spacing.
inline constexpr double kFirmSpacing = 0.25;

/// The radius, over the spacing, with which balls of a lattice stick out of a cube as far as the
/// gaps between them are deep: (1 + sqrt 3) / 4.
inline constexpr double kVolumeRadius = 0.6830127018922193;

}  // namespace stillgrid::spheres
