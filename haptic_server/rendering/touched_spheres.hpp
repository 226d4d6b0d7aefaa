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
  Eigen::Vector3d before_m;  // where the last tick that saw the scene placed it
};

/// A sphere of the scene as displayed, that a sphere of the tool overlaps.
struct TouchedSphere {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
  double radius_m;
  std::uint32_t material;
  std::uint32_t tool_sphere;  // which one overlaps it
  bool swept;  // only on the way to this tick; then position_m is where the two were closest
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
  /// A contact on the way is of one tick; shown in the next it would be where nothing is.
  void drop_swept() noexcept;
};

/// Covers and rows of cells that one sphere of the tool may look at in a grid, whatever the segment
/// says.
inline constexpr std::uint32_t kMaxVisits = 8192;

/// How a grid's spheres are displayed in this tick, and were in the tick before.
struct DisplayedMotion {
  ImageWeights now;
  ImageWeights before;
};

/// Adds to `touched` the spheres of a grid that overlap the tool where `shown` displays them.
/// [Davanne 2002, section 3: the still grid as intermediate model, the tool never entered.]
///
/// Swept: where tool and sphere moved past one another by more than half the tool sphere's radius
/// since the tick before, and overlap at neither end, they are also tested where they came closest
/// on the straight way. Shorter moves can miss no overlap deeper than a 32nd of that radius.
/// Realtime: wait-free, allocates nothing. Safe on words that change or lie; what was gathered
/// counts only once the read was accepted, and only finite overlaps are kept.
void gather_touched(const GridView& grid, const DisplayedMotion& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

}  // namespace stillgrid
