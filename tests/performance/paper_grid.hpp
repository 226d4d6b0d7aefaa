#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sim_server/contact/pair_search.hpp"

namespace stillgrid::performance {

/// What a step of the paper's grid did.
struct PaperCounts {
  std::uint64_t entries = 0;  // of moving spheres in voxels
  std::uint64_t visits = 0;   // of a sphere that stands in a voxel's list, by another
  std::uint64_t tests = 0;    // of distances: visits but those that a stamp tells are repeated
};

/// The paper's own collision detection [Davanne 2002, section 2], a baseline to measure against:
/// every voxel that a sphere's box meets lists it, and a sphere is tested against those that stand
/// in its voxels before it joins them. A stamp on a sphere tells that it was just tested, one on a
/// voxel that its list is of an earlier step, so that nothing is ever emptied. Spheres that never
/// move are entered once.
///
/// The grid repeats after its cells along each axis. A stamp that wraps loses pairs: Stamp is as
/// wide as a test wants it, first_stamp where the count of checks begins.
template <class Stamp>
class PaperGrid {
 public:
  PaperGrid(float voxel_m, const std::array<std::uint32_t, 3>& cells, Stamp first_stamp = 0);

  /// Enters the spheres that never move. Their numbers follow those of the moving ones.
  void enter_static(std::span<const collision::SweptBound> balls);

  /// Writes the pairs of balls that overlap, still ones among themselves apart. balls: those that
  /// move, as many at each call.
  PaperCounts find(std::span<const collision::SweptBound> balls,
                   std::vector<contact::SpherePair>& pairs);

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  struct Entry {
    std::uint32_t sphere, next;
  };
  struct VoxelList {
    std::uint32_t first = kNone, first_static = kNone;
    Stamp stamp = 0;
  };

  template <class Visit>
  void for_each_voxel(const collision::SweptBound& ball, Visit&& visit);
  void put(std::uint32_t sphere, std::uint32_t& first, std::vector<Entry>& entries);

  float inverse_voxel_per_m_;
  std::array<std::uint32_t, 3> cells_;
  std::vector<VoxelList> voxels_;
  std::vector<Entry> entries_, static_entries_;
  std::vector<collision::SweptBound> static_;
  std::vector<Stamp> tested_;  // when a sphere was last tested
  Stamp check_;                // of the sphere that is being checked
  Stamp step_ = 0;
};

extern template class PaperGrid<std::uint16_t>;
extern template class PaperGrid<std::uint32_t>;
extern template class PaperGrid<std::uint64_t>;

}  // namespace stillgrid::performance
