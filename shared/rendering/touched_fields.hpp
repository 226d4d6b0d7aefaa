#pragma once

#include <cstdint>
#include <span>

#include "shared/display/displayed_field.hpp"
#include "shared/publication/published_fields.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Samples of fields that one gathering may take, whatever the segment says.
inline constexpr std::uint32_t kMaxFieldSamples = 2048;

/// Adds to `touched` a sphere for each of the tool's that meets a field where `shown` displays it.
///
/// The sphere is tangent to the solid there, of the radius of the ball that holds the solid: the
/// contact law knows spheres only. Depth and normal are
/// the field's own.
/// Realtime: as gather_touched().
void gather_moving_fields(std::span<const publication::SceneField> fields,
                          const collision::GridView& moving, const display::SnapshotWeights& shown,
                          std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

/// The same of fields that never move.
void gather_static_fields(std::span<const publication::SceneField> fields,
                          std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

}  // namespace stillgrid::rendering
