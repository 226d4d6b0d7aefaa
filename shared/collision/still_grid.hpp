#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/scene_segment.hpp"
#include "shared/publication/double_buffer.hpp"

namespace stillgrid {

/// Where the arrays of a grid stand in a block of 8-byte words, for a given capacity.
struct GridLayout {
  std::size_t records = 0;      // SphereRecord, 16 words each
  std::size_t cell_starts = 0;  // u32, cells + 1: cell c holds entries [starts[c], starts[c + 1])
  std::size_t entries = 0;      // u32 sphere numbers, ascending within a cell
  std::size_t long_list = 0;    // u32 sphere numbers
  std::size_t total_words = 0;
  std::size_t sphere_capacity = 0;
  std::uint32_t log2_cell_capacity = 0;
};

/// Room for sphere_capacity spheres behind header_bytes. It cannot be outgrown: a sphere makes at
/// most kMaxVoxelsPerSphere entries, then it is on the long list.
[[nodiscard]] GridLayout grid_layout(std::size_t header_bytes, std::size_t sphere_capacity,
                                     std::uint32_t log2_cell_capacity);

/// Cells that suit a number of spheres: four a sphere, 64 at least.
[[nodiscard]] std::uint32_t log2_cells_for(std::size_t sphere_count);

/// A filled grid to read, in private memory or in a segment that another process may be writing.
/// The shape is a local copy, already checked against the layout (is_consistent).
struct GridView {
  proto::GridShape shape{};
  GridLayout layout{};
  const std::uint64_t* words = nullptr;  // start of the block that layout counts from
};

/// Whether a shape read from shared memory fits its layout, so that every index it leads to is
/// bounded.
[[nodiscard]] bool is_consistent(const proto::GridShape& shape, const GridLayout& layout) noexcept;

/// The voxel that holds a coordinate. Monotone, saturating: spheres that overlap share a voxel.
/// Realtime: yes.
[[nodiscard]] std::int32_t voxel_index(float coordinate_m, float inverse_voxel_per_m) noexcept;

/// An axis-aligned box in metres, floats as published.
struct Box {
  std::array<float, 3> low_m;
  std::array<float, 3> high_m;
};

/// The paper's voxel grid [Davanne 2002, section 2, Figs. 2-3], in private memory: a sphere is
/// entered in every voxel that its box meets, the box being swept over all images of its history,
/// so that a transition may display it anywhere between them.
///
/// Arrays are allocated once; filling allocates nothing.
class StillGrid {
 public:
  StillGrid(std::size_t header_bytes, std::size_t sphere_capacity);

  /// The spheres, to be written before fill(); lowest_voxel is fill()'s to write.
  [[nodiscard]] std::span<proto::SphereRecord> records() noexcept;

  /// Enters the first `sphere_count` records in voxels of edge voxel_m.
  /// Counting sort: O(spheres + entries + cells). Pre: voxel_m > 0, all records finite.
  void fill(std::size_t sphere_count, float voxel_m);

  [[nodiscard]] GridView view() const noexcept;
  [[nodiscard]] const GridLayout& layout() const noexcept { return layout_; }
  [[nodiscard]] std::span<std::uint64_t> words() noexcept { return words_; }

  /// The words that a publication of the filled grid must copy, the header apart.
  [[nodiscard]] std::array<PayloadPart, 4> filled_parts() const noexcept;

 private:
  [[nodiscard]] std::uint32_t* u32_at(std::size_t word) noexcept;

  GridLayout layout_;
  proto::GridShape shape_{};
  std::vector<std::uint64_t> words_;
  std::vector<std::array<std::int32_t, 3>> highest_voxel_;
};

/// The box of a sphere at one place. Realtime: yes.
[[nodiscard]] Box box_round(const Eigen::Vector3d& centre_m, double radius_m) noexcept;

/// The box swept by a sphere over the images of its history. Realtime: yes.
[[nodiscard]] Box swept_box(const proto::SphereRecord& record) noexcept;

}  // namespace stillgrid
