#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/scene_segment.hpp"
#include "shared/collision/grid_query.hpp"

namespace stillgrid::collision {

/// The static spheres of a scene, listed in every voxel where the centre of a sphere of up to
/// probe_radius_m can be that touches them: a query looks into one voxel a level, and finds place
/// and radius there (docs/algorithms/voxel_grid.md).
///
/// A level holds an octave of radius and probe radius together, so that radii of any range are
/// entered in a bounded number of voxels: 64 at most.
class TouchLists {
 public:
  /// A sphere that is nowhere (no number) is in no list. Throws std::length_error beyond 2^32
  /// entries. Pre: probe_radius_m > 0, all other places and radii are finite.
  TouchLists(std::span<const proto::SphereRecord> spheres, float probe_radius_m);

  /// Its offset is the owner's to write.
  [[nodiscard]] const proto::TouchShape& shape() const noexcept { return shape_; }
  [[nodiscard]] std::span<const std::uint64_t> words() const noexcept { return words_; }

 private:
  proto::TouchShape shape_{};
  std::vector<std::uint64_t> words_;
};

/// Words of an entry.
inline constexpr std::size_t kTouchEntryWords = 4;

/// A static sphere that a list tells of. World frame.
struct TouchEntry {
  std::array<float, 3> centre_m;
  float radius_m;
  proto::TouchLabel label;
};

/// Return the place of the entries from the start of the lists, and the size of the lists, in
/// words.
[[nodiscard]] std::size_t touch_entry_word(const proto::TouchShape& shape) noexcept;
[[nodiscard]] std::size_t touch_words(const proto::TouchShape& shape) noexcept;

/// Whether a shape read from shared memory leads to no cell that it does not count.
/// Realtime: yes.
[[nodiscard]] bool is_consistent(const proto::TouchShape& shape) noexcept;

/// Touch lists to read, in private memory or in a segment that another process may be writing.
class TouchView {
 public:
  TouchView() = default;
  /// Pre: is_consistent(shape), touch_words(shape) stand at `words`. sphere_count: of the scene;
  /// entries of other spheres are passed over.
  TouchView(const proto::TouchShape& shape, std::uint32_t sphere_count, const std::uint64_t* words);

  [[nodiscard]] const proto::TouchShape& shape() const noexcept { return shape_; }
  [[nodiscard]] float probe_radius_m() const noexcept { return shape_.probe_radius_m; }

  /// Calls visit(const TouchEntry&) once for each sphere that the probe may touch, and for
  /// few others. Looks at max_visits entries at most and returns whether it was cut short there.
  ///
  /// Realtime: wait-free; safe on words that change or lie. Pre: probe.bounding_radius_m <=
  /// probe_radius_m(), or spheres that it touches may not be found.
  template <class Visit>
  bool for_each_touch(const SweptBound& probe, std::uint32_t max_visits, Visit&& visit) const;

 private:
  /// How a level turns a place into a cell.
  struct Level {
    Int4 lowest, highest;
    Unsigned4 mask;  // of the cells, along an axis that repeats
    float inverse_voxel_per_m;
    std::uint32_t first_cell, row, layer;
  };
  /// A list that is within the entries, whatever the words say.
  struct List {
    const std::uint64_t* words;
    std::uint32_t count;
  };
  [[nodiscard]] List list_at(const Level& level, const SweptBound& probe) const noexcept;
  /// Which of the four entries from number `i` on meet the probe, a bit each.
  [[nodiscard]] static unsigned meet4(const List& list, std::uint32_t i,
                                      const SweptBound& probe) noexcept;
  [[nodiscard]] static TouchEntry entry(const List& list, std::uint32_t i) noexcept;

  proto::TouchShape shape_{};
  std::uint32_t sphere_count_ = 0;
  const std::uint64_t *starts_ = nullptr, *entries_ = nullptr;
  std::array<Level, proto::kMaxLevels> levels_{};
};

inline TouchView::List TouchView::list_at(const Level& level,
                                          const SweptBound& probe) const noexcept {
  const auto& c = probe.centre_m;
  const Int4 voxel = voxel_index(Float4{c[0], c[1], c[2], 0.0F}, level.inverse_voxel_per_m);
  const Int4 outside = (voxel < level.lowest) | (voxel > level.highest);
  if ((outside[0] | outside[1] | outside[2]) != 0) return {entries_, 0};
  const Unsigned4 at =
      (std::bit_cast<Unsigned4>(voxel) - std::bit_cast<Unsigned4>(level.lowest)) & level.mask;
  const std::size_t cell = level.first_cell + at[0] + level.row * at[1] + level.layer * at[2];
  const std::uint32_t first = double_buffer::load_u32(starts_, cell);
  const std::uint32_t end =
      std::min(double_buffer::load_u32(starts_, cell + 1), shape_.entry_count);
  if (first >= end) return {entries_, 0};
  return {entries_ + kTouchEntryWords * first, (end - first) & ~1U};
}

inline unsigned TouchView::meet4(const List& list, std::uint32_t i,
                                 const SweptBound& probe) noexcept {
  constexpr float kOutwards =
      1.0F + 2e-6F;  // radii are not rounded outwards: more than this rounds
  const auto numbers = [&](std::uint32_t axis) {
    return detail::load4(list.words + (axis * list.count + i) / 2);
  };
  const Float4 x = numbers(0) - probe.centre_m[0], y = numbers(1) - probe.centre_m[1],
               z = numbers(2) - probe.centre_m[2],
               apart = (numbers(3) + probe.bounding_radius_m) * kOutwards;
  return detail::bits_of(x * x + y * y + z * z <= apart * apart);
}

inline TouchEntry TouchView::entry(const List& list, std::uint32_t i) noexcept {
  const auto number = [&](std::uint32_t axis) {
    return std::bit_cast<float>(double_buffer::load_u32(list.words, axis * list.count + i));
  };
  return {{number(0), number(1), number(2)},
          number(3),
          double_buffer::load_struct<proto::TouchLabel>(list.words +
                                                        std::size_t{2} * (list.count + i))};
}

template <class Visit>
bool TouchView::for_each_touch(const SweptBound& probe, std::uint32_t max_visits,
                               Visit&& visit) const {
  std::uint32_t left = max_visits;
  for (std::uint32_t k = 0; k < shape_.level_count; ++k) {
    const List list = list_at(levels_[k], probe);
    const std::uint32_t stop = std::min(list.count, left);
    for (std::uint32_t i = 0; i < stop; i += kBoundsAtOnce) {
      unsigned met = meet4(list, i, probe);
      met &= 0xFU >> (kBoundsAtOnce - std::min(stop - i, kBoundsAtOnce));
      for (; met != 0; met &= met - 1) {
        const TouchEntry found = entry(list, i + static_cast<unsigned>(std::countr_zero(met)));
        if (found.label.number < sphere_count_) visit(found);  // else a hostile word
      }
    }
    if (stop != list.count) return true;
    left -= stop;
  }
  return false;
}

}  // namespace stillgrid::collision
