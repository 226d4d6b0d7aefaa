#pragma once

#include <span>

#include "shared/collision/touch_lists.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Adds to `touched` the static spheres that overlap the tool. A tool sphere that is wider than the
/// lists are for is searched for in the grid, which holds the same spheres. Realtime: as
/// gather_touched().
void gather_statics(const collision::TouchView& lists, const collision::GridView& grid,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

}  // namespace stillgrid::rendering
