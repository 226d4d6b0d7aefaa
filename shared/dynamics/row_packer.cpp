#include "shared/dynamics/row_packer.hpp"

#include <bit>

namespace stillgrid::dynamics {

void RowPacker::start(std::size_t movers) {
  busy_.resize(movers);  // none is busy
  rows_.clear();
}

void RowPacker::add(std::int32_t item, std::span<const std::int32_t> movers) {
  std::uint64_t busy = 0;
  for (const std::int32_t mover : movers) busy |= busy_[static_cast<std::size_t>(mover)];
  if (~busy == 0) close(0);
  const auto k = ~busy == 0 ? std::size_t{0} : static_cast<std::size_t>(std::countr_one(busy));
  OpenRow& row = open_[k];
  row.items[row.count++] = item;
  for (const std::int32_t mover : movers) {
    row.movers[row.mover_count++] = mover;
    busy_[static_cast<std::size_t>(mover)] |= std::uint64_t{1} << k;
  }
  if (row.count == kRowLanes) close(k);
}

void RowPacker::close(std::size_t open) {
  OpenRow& row = open_[open];
  if (row.count == 0) return;
  for (std::size_t i = row.count; i < kRowLanes; ++i) row.items[i] = -1;
  for (std::size_t i = 0; i < row.mover_count; ++i)
    busy_[static_cast<std::size_t>(row.movers[i])] &= ~(std::uint64_t{1} << open);
  rows_.push_back(row.items);
  row.count = row.mover_count = 0;
}

void RowPacker::finish() {
  for (std::size_t k = 0; k < kOpen; ++k) close(k);
}

}  // namespace stillgrid::dynamics
