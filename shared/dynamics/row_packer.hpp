#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/contact_row.hpp"

namespace stillgrid::dynamics {

/// Packs items in rows in which no mover occurs twice, in the order in which rows fill up. The
/// result depends on the items and their order alone.
///
/// Thread: one. Memory is kept from use to use.
class RowPacker {
 public:
  /// Numbers of the items of a row; -1 where the row is not full.
  using Row = std::array<std::int32_t, kRowLanes>;

  /// Begins anew. movers: their count. Pre: finish() followed the last add().
  void start(std::size_t movers);
  /// Adds an item; movers: those that an impulse moves.
  void add(std::int32_t item, std::span<const std::int32_t> movers);
  /// Makes room, so that rows up to this number do not allocate.
  void reserve(std::size_t rows) { rows_.reserve(rows + kOpen); }
  /// Ends all open rows. The next item begins a new one.
  void finish();
  [[nodiscard]] std::span<const Row> rows() const noexcept { return rows_; }

 private:
  static constexpr std::size_t kOpen = 64;  // rows: bits of a mask
  static constexpr std::size_t kMaxMovers = 8;
  struct OpenRow {
    std::size_t count = 0, mover_count = 0;
    Row items{};
    std::array<std::int32_t, kMaxMovers * kRowLanes> movers{};
  };
  void close(std::size_t open);

  std::vector<OpenRow> open_ = std::vector<OpenRow>(kOpen);
  std::vector<std::uint64_t> busy_;  // movers: bits of the open rows that have it
  std::vector<Row> rows_;
};

}  // namespace stillgrid::dynamics
