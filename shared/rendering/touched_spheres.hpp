#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "shared/collision/voxel_grid.hpp"
#include "shared/display/transition.hpp"

namespace stillgrid::rendering {

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
  std::uint32_t number = 0;  // in its grid
  Eigen::Vector3d compliance_m_per_N =
      Eigen::Vector3d::Zero();  // a newton that the tool's force changes
  bool compliant = false;       // its force is part of the push to which spheres give way
  double presence =
      1.0;  // weight of the displayed snapshots in which it is; its force is so much less
};

/// What a tick gathered, in memory of its own and of fixed size.
struct TouchedSpheres {
  static constexpr std::size_t kCapacity = 512;
  std::array<TouchedSphere, kCapacity> spheres;
  std::size_t count = 0;
  bool truncated = false;  // more was there than may be looked at or kept in a tick

  [[nodiscard]] std::span<const TouchedSphere> all() const noexcept {
    return {spheres.data(), count};
  }
  void clear() noexcept {
    count = 0;
    truncated = false;
  }
  [[nodiscard]] bool has_swept() const noexcept {
    return std::any_of(all().begin(), all().end(), [](const auto& sphere) { return sphere.swept; });
  }
  /// A contact on the way is of one tick; shown in the next it would be where nothing is.
  void drop_swept() noexcept;
};

/// Covers and rows of cells that one sphere of the tool may look at in a grid, whatever the segment
/// says.
inline constexpr std::uint32_t kMaxVisits = 8192;

/// How spheres are displayed that give way to the tool's force.
struct CompliantDisplay {
  double change_N = 0.0;  // of the force, from that in the snapshot, to which they have given way
  double slack_N = 0.0;   // of it, either way, for which all contacts are wanted
  double max_m_per_N = 0.0;                           // that any sphere gives way
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  // of all
};

/// How a grid's spheres are displayed in this tick, and were in the tick before.
struct DisplayedMotion {
  display::SnapshotWeights now;
  display::SnapshotWeights before;
  CompliantDisplay compliant_display = {};
};

/// Where sphere `number` of a grid is displayed. Realtime: safe on words that change or lie.
/// Pre: number < grid.shape.sphere_count.
[[nodiscard]] Eigen::Vector3d displayed_m(const collision::GridView& grid, std::uint32_t number,
                                          const display::SnapshotWeights& weights,
                                          const CompliantDisplay& compliant_display) noexcept;

/// Adds to `touched` the spheres of a grid that overlap the tool where `shown` displays them, or
/// would if they given way by less or more within the slack.
/// [Davanne 2002, section 3: the static grid as intermediate model, the tool never entered.]
///
/// Swept: where tool and sphere moved past one another by more than half the tool sphere's radius
/// since the tick before, and overlap at neither end, they are also tested where they came closest
/// on the straight way. Shorter moves can miss no overlap deeper than a 32nd of that radius.
/// A sphere is absent from the snapshots in which its position is not a number: it is displayed by
/// the others, and not swept. Realtime: wait-free, allocates nothing. Safe on words that change or
/// lie; what was gathered counts only once the read was accepted, and only finite overlaps are
/// kept.
void gather_touched(const collision::GridView& grid, const DisplayedMotion& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

}  // namespace stillgrid::rendering
