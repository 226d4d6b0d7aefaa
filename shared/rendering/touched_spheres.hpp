#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "proto/tool_segment.hpp"
#include "shared/collision/smooth_cover.hpp"
#include "shared/collision/voxel_grid.hpp"
#include "shared/display/transition.hpp"

namespace stillgrid::rendering {

/// A sphere of the tool, placed in the scene for one tick.
struct PlacedToolSphere {
  Eigen::Vector3d position_m;
  double radius_m;
  // Radius if this is a proxy's reach. Neighbours of the spheres that push are gathered, too.
  double proxy_radius_m = 0.0;
  // Centre of the tool's sphere if this is its proxy's reach.
  std::optional<Eigen::Vector3d> device_m = std::nullopt;
};

/// Returns the distance of centres within which a sphere is gathered, m.
[[nodiscard]] inline double gathered_within_m(const PlacedToolSphere& probe, double radius_m) {
  return probe.radius_m + radius_m +
         collision::SmoothCover::neighbour_gap_m(probe.proxy_radius_m, radius_m);
}
/// Returns a ball that every gathered sphere meets.
[[nodiscard]] inline collision::SweptBound gathering_bound(const PlacedToolSphere& probe) {
  return collision::bound_sphere(
      probe.position_m, probe.radius_m + collision::SmoothCover::margin_m(probe.proxy_radius_m));
}

/// A sphere of the scene as displayed, that a sphere of the tool overlaps.
struct TouchedSphere {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
  double radius_m;
  std::uint32_t material;
  std::uint32_t tool_sphere;  // which one overlaps it
  std::uint32_t number = 0;   // in its grid
  std::uint32_t body = 0;     // order in the scene file
  // Weight of the displayed snapshots in which it is: its force is so much less. Of a field the
  // stiffness over the material's.
  double presence = 1.0;
  bool is_static = false;
  bool is_given = false;          // a local copy of a publisher's bodies shows it
  std::uint32_t field = 0;        // that it stands for, among SceneView::fields() from 1; 0: none
  double energy_share = 1.0;      // of its spring's energy, beside that of a force linear in depth
  float crushing_force_N = 0.0F;  // see proto::SphereRecord
};

/// Spheres that a tick may visit, whatever the segment says. A query for one tool sphere looks at
/// as many swept bounds and rows of cells at most.
inline constexpr std::uint32_t kMaxVisits = 8192;

/// Surfaces that a tick gathered, in memory of fixed size.
struct TouchedSpheres {
  static constexpr std::size_t kCapacity = 2048;
  std::array<TouchedSphere, kCapacity> spheres;
  std::size_t count = 0;
  std::uint32_t visits_left = kMaxVisits;  // in this tick, for all spheres of the tool
  bool truncated = false;                  // more was there than may be looked at or kept in a tick

  [[nodiscard]] std::span<const TouchedSphere> all() const noexcept {
    return {spheres.data(), count};
  }
  void clear() noexcept {
    count = 0;
    visits_left = kMaxVisits;
    truncated = false;
  }
  /// Counts a visit. Returns false, and notes the truncation, once no visit is left or the memory
  /// is full.
  [[nodiscard]] bool may_visit() noexcept {
    const bool may = visits_left > 0 && count < kCapacity;
    truncated = truncated || !may;
    visits_left -= may ? 1 : 0;
    return may;
  }
  /// Adds a sphere, or notes the truncation where the memory is full.
  void add(const TouchedSphere& sphere) noexcept {
    truncated = truncated || count == kCapacity;
    if (count < kCapacity) spheres[count++] = sphere;
  }
  template <class Is>
  void remove_if(Is&& is) noexcept {
    const auto end = spheres.begin() + static_cast<std::ptrdiff_t>(count);
    count = static_cast<std::size_t>(std::remove_if(spheres.begin(), end, is) - spheres.begin());
  }
};

/// Adds to `touched` the spheres of a grid that overlap the tool where `shown` displays them.
/// [Davanne 2002, section 3: the static grid as intermediate model, the tool never entered.]
///
/// A sphere is absent from a snapshot in which its position is not a number: it is displayed by the
/// other. Points of bodies that have fields are nobody's to touch. Realtime:
/// wait-free, allocates nothing. Safe on words that change or lie; what was gathered counts only
/// once the read was accepted, and only finite overlaps are kept.
void gather_touched(const collision::GridView& grid, const display::SnapshotWeights& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

}  // namespace stillgrid::rendering
