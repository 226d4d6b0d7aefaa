#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "shared/collision/voxel_grid.hpp"
#include "sim_server/contact/pair_search.hpp"

namespace stillgrid::contact {

/// Which two spheres may collide at all; empty: any two.
using PairFilter = std::function<bool(std::uint32_t, std::uint32_t)>;

/// Spheres that move: which of them overlap, and the grid that holds them.
///
/// Each sphere has a swept bound, ahead of it and wider than it needs. The grid is filled by swept
/// bounds and its pairs of swept bounds that meet are listed; while every sphere stays within its
/// swept bound a step only tests the pairs of the list. The few that leave theirs are widened in
/// place; when many do, or one strays far, all are covered and entered anew. How far swept bounds
/// extend depends on how the spheres moved and on how many pairs there are, never on a clock
/// (docs/algorithms/voxel_grid.md).
///
/// Nothing is allocated once the lists have been as long as the scene needs.
class MovingSpheres {
 public:
  /// voxel_ratio: as for VoxelGrid::enter(); none or negative: chosen from the scene. groups: of
  /// each sphere, kNoGroup or one whose spheres are never paired with each other, and cost no
  /// memory for it; none: there are no groups.
  MovingSpheres(std::size_t count, float voxel_ratio, std::vector<std::uint32_t> groups = {});

  /// Enters the spheres as they are, before the first find(), which else does so. Throws as find().
  /// Pre: balls.size() is the count.
  void enter(std::span<const collision::SweptBound> balls);

  /// The pairs of balls that overlap, (dx dx + dy dy + dz dz) < (ra + rb)^2 in float arithmetic,
  /// and that `may_collide` admits, each once. balls[i]: all that sphere i may take up during this
  /// step. Throws std::domain_error, naming the sphere, at a ball that is no number.
  /// `may_collide` must answer the same at every call. Pre: balls.size() is the count.
  std::span<const SpherePair> find(std::span<const collision::SweptBound> balls,
                                   const PairFilter& may_collide = {}) {
    return *find_at_most(balls, may_collide, std::numeric_limits<std::size_t>::max());
  }

  /// The same, or nothing where more than `most` pairs would have to be listed, each of which takes
  /// memory; then the next call lists them anew.
  std::optional<std::span<const SpherePair>> find_at_most(
      std::span<const collision::SweptBound> balls, const PairFilter& may_collide,
      std::size_t most);

  /// Every swept bound holds its sphere's ball of the last enter() or find(). The owner may write
  /// the records, which nothing here reads, and let swept bounds grow.
  [[nodiscard]] collision::VoxelGrid& grid() noexcept { return grid_; }
  [[nodiscard]] const collision::VoxelGrid& grid() const noexcept { return grid_; }

  /// What the list of pairs holds for, of a sphere that was entered: its swept bound before it
  /// grew.
  [[nodiscard]] const collision::SweptBound& swept_bound(std::size_t sphere) const noexcept {
    return swept_bounds_[sphere];
  }

  /// Returns whether a swept bound has grown beyond its level's octave. Every query of the level
  /// looks as far, until all are entered anew.
  [[nodiscard]] bool is_outgrown() const noexcept;

  /// How often all swept bounds were made anew, and pairs that are tested every step.
  [[nodiscard]] std::uint64_t entered_count() const noexcept { return entered_count_; }
  [[nodiscard]] std::size_t listed_pairs() const noexcept { return listed_; }
  /// Pairs that memory was taken for.
  [[nodiscard]] std::size_t room_for_pairs() const noexcept {
    return candidates_.capacity() + pairs_.capacity();
  }

 private:
  [[nodiscard]] bool list_holds(std::span<const collision::SweptBound> balls,
                                const PairFilter& may_collide);
  [[nodiscard]] bool widen(std::uint32_t sphere, const collision::SweptBound& ball,
                           const PairFilter& may_collide);
  void plan(std::span<const collision::SweptBound> balls);
  void make_bounds(std::span<const collision::SweptBound> balls);
  void fill_grid();
  float fill_levels();
  [[nodiscard]] bool list_pairs(const PairFilter& may_collide, std::size_t most);

  collision::VoxelGrid grid_;
  bool chooses_voxel_;
  float voxel_ratio_;
  float voxel_m_ = 0.0F;                             // that is chosen, if it can be
  std::uint32_t octaves_ = 2;                        // of radius that share a level
  std::vector<collision::SweptBound> swept_bounds_;  // of each sphere: what the list holds for
  float longest_m_ = 0.0F;                           // radius among them, before they grew
  std::vector<collision::SweptBound> entered_;       // the balls as they were entered
  std::vector<Eigen::Vector3f> moves_m_;             // of some in a step, as last measured
  std::vector<std::uint32_t> groups_;
  SortedBounds sorted_;
  std::vector<SpherePair> candidates_;  // the first listed_ of them
  std::vector<SpherePair> pairs_;       // room for as many
  std::size_t listed_ = 0, listed_when_entered_ = 0, found_ = 0;
  std::vector<std::uint32_t> escaped_;  // room for as many as are widened at once
  std::uint64_t entered_count_ = 0;
  bool is_listed_ = false;
  int steps_ = 0;             // since the spheres were entered
  int rebuild_interval_ = 1;  // steps that the swept bounds are made for
  float lead_ = 0.0F;         // part of its last move that a sphere is expected to repeat
  float error_m_ = 0.0F;      // of that expectation, a step
};

}  // namespace stillgrid::contact
