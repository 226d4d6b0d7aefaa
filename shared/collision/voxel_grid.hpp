#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/scene_segment.hpp"
#include "shared/double_buffer/double_buffer.hpp"

namespace stillgrid::collision {

using proto::SweptBound;

/// A query looks at so many swept bounds at once, and may look beyond the last one of a grid.
inline constexpr std::uint32_t kBoundsAtOnce = 4;
/// Words of a VoxelGrid beyond its last array, so that wider vectors may be read over the end.
inline constexpr std::size_t kSparedWords = 16;

/// Where the arrays of a grid stand in a block of 8-byte words, for a given capacity.
struct GridLayout {
  std::size_t records = 0;  // SphereRecord, 8 words each, in the order of sphere numbers
  std::size_t cell_starts =
      0;  // u32, cells + 1: cell c holds swept bounds [starts[c], starts[c + 1])
  std::size_t swept_bounds = 0;  // SweptBound, 2 words each, sorted by level, cell and number
  std::size_t numbers = 0;       // u32, the sphere of each swept bound
  std::size_t total_words = 0;
  std::size_t sphere_capacity = 0;
  std::size_t cell_capacity = 0;  // of all levels together

  bool operator==(const GridLayout&) const = default;
};

/// Room for sphere_capacity spheres behind header_bytes. It cannot be outgrown: a sphere is
/// entered once, and a level repeats in space rather than take more cells than its spheres pay for.
[[nodiscard]] GridLayout grid_layout(std::size_t header_bytes, std::size_t sphere_capacity);

/// A filled grid to read, in private memory or in a segment that another process may be writing.
/// The shape is a local copy, already checked against the layout (is_consistent).
struct GridView {
  proto::GridShape shape{};
  GridLayout layout{};
  const std::uint64_t* words = nullptr;  // start of the block that layout counts from
  // Of a snapshot in a segment: FieldRecords of the fields that move, numbered as they are.
  const std::uint64_t* fields = nullptr;
  std::uint32_t field_count = 0;
};

/// Whether a shape read from shared memory fits its layout, so that every index it leads to is
/// bounded. Realtime: yes.
[[nodiscard]] bool is_consistent(const proto::GridShape& shape, const GridLayout& layout) noexcept;

/// The snapshot of a scene: its spheres with the snapshots of their history, entered in the voxel
/// grid [Davanne 2002, section 2], in private memory.
///
/// A sphere is entered once, by the centre of its swept bound, in the level of its swept bound's
/// octave; a query looks as far round itself as that level's swept bounds extend
/// (docs/algorithms/voxel_grid.md). Arrays are allocated once; entering allocates nothing.
class VoxelGrid {
 public:
  VoxelGrid(std::size_t header_bytes, std::size_t sphere_capacity);

  /// All spheres of the capacity. Radius, material and body are the owner's to write.
  [[nodiscard]] std::span<proto::SphereRecord> records() noexcept;
  [[nodiscard]] std::span<const proto::SphereRecord> records() const noexcept;

  /// One more snapshot of every sphere. The first one fills the history. Pre: snapshots.size() is
  /// the capacity.
  void push_snapshot(std::span<const proto::SphereState> snapshots) noexcept;

  /// Enters swept bounds[i] for sphere i. voxel_ratio: a voxel's edge over twice the level's
  /// radius. octaves: of radius that share a level. Counting sort: O(spheres + cells). Throws
  /// std::domain_error, and leaves the grid as it was, at a swept bound that is not finite or
  /// reaches nowhere: what is no number is refused here. Pre: voxel_ratio > 0, octaves > 0, swept
  /// bounds.size() is the capacity or less.
  void enter(std::span<const SweptBound> swept_bounds, float voxel_ratio,
             std::uint32_t octaves = 1);

  /// Lets the swept bound of a sphere that was entered reach at least bounding_radius_m from where
  /// its centre is.
  void grow(std::size_t sphere, float bounding_radius_m) noexcept;

  /// The swept bound of a sphere that was entered, as it is published.
  [[nodiscard]] const SweptBound& swept_bound(std::size_t sphere) const noexcept;

  [[nodiscard]] GridView view() const noexcept;
  [[nodiscard]] const GridLayout& layout() const noexcept { return layout_; }
  [[nodiscard]] std::span<std::uint64_t> words() noexcept {
    return {words_.data(), layout_.total_words};
  }

  /// The swept bounds in the order of the cells, and the sphere of each.
  [[nodiscard]] std::span<const SweptBound> sorted_bounds() const noexcept;
  [[nodiscard]] std::span<const std::uint32_t> sorted_numbers() const noexcept;

  /// The words that a publication of the filled grid must copy, the header apart.
  [[nodiscard]] std::array<double_buffer::PayloadPart, 4> filled_parts() const noexcept;

 private:
  [[nodiscard]] std::uint32_t* u32_at(std::size_t word) noexcept;
  void shape_levels(std::span<const SweptBound> swept_bounds, float voxel_ratio,
                    std::uint32_t octaves);
  void sort_bounds(std::span<const SweptBound> swept_bounds);

  GridLayout layout_;
  proto::GridShape shape_{};
  bool has_snapshot_ = false;
  std::vector<std::uint64_t> words_;
  std::vector<std::uint8_t> level_of_;   // of each sphere, where there are several levels
  std::vector<std::uint32_t> place_of_;  // of each sphere's swept bound among the sorted ones
};

/// The ball that holds a sphere at one place, or on the straight ways between two or three; rounded
/// outwards.
/// Realtime: yes.
[[nodiscard]] SweptBound bound_sphere(const Eigen::Vector3d& centre_m, double radius_m) noexcept;
[[nodiscard]] SweptBound bound_sweep(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m,
                                     double radius_m) noexcept;
[[nodiscard]] SweptBound bound_sweep(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m,
                                     const Eigen::Vector3d& or_to_m, double radius_m) noexcept;

/// The ball that holds a sphere in the snapshots of its history in which it is present, and between
/// them; rounded outwards. Of one that is in none: round the origin.
[[nodiscard]] SweptBound bound_history(const proto::SphereRecord& record) noexcept;

/// Swept bounds of many spheres, for VoxelGrid::enter().
[[nodiscard]] std::vector<SweptBound> history_bounds(std::span<const proto::SphereRecord> records);

}  // namespace stillgrid::collision
