#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "haptic_server/rendering/transition.hpp"
#include "shared/collision/still_grid.hpp"

namespace stillgrid {

/// A sphere of the tool, placed in the scene for one tick.
struct PlacedToolSphere {
  Eigen::Vector3d position_m;
  double radius_m;
};

/// A sphere of the scene as displayed, that a sphere of the tool overlaps.
struct TouchedSphere {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
  double radius_m;
  std::uint32_t material;
  std::uint32_t tool_sphere;  // which one overlaps it
};

/// What a tick gathered, in memory of its own and of fixed size.
struct TouchedSpheres {
  static constexpr std::size_t kCapacity = 512;
  std::array<TouchedSphere, kCapacity> spheres;
  std::size_t count = 0;
  bool cut = false;  // more was there than may be looked at or kept in a tick

  [[nodiscard]] std::span<const TouchedSphere> all() const noexcept {
    return {spheres.data(), count};
  }
  void clear() noexcept {
    count = 0;
    cut = false;
  }
};

/// Entries and voxels that one sphere of the tool may look at in a grid, whatever the segment says.
inline constexpr std::uint32_t kMaxVisits = 8192;

/// Adds to `touched` the spheres of a grid that overlap the tool where `weights` displays them.
/// [Davanne 2002, section 3: the still grid as intermediate model, the tool never entered.]
///
/// Realtime: wait-free, allocates nothing. Safe on words that change or lie; what was gathered
/// counts only once the read was accepted, and only finite overlaps are kept.
void gather_touched(const GridView& grid, const ImageWeights& weights,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

}  // namespace stillgrid
