#include "sim_server/dynamics/forces/block_matrix.hpp"

#include <algorithm>

namespace stillgrid::dynamics {

void BlockMatrix::reset(Eigen::Index size) {
  if (size != size_) {
    size_ = size;
    columns_.assign(static_cast<std::size_t>(size / 3), {});
    blocks_.clear();
    calls_.clear();
    changed_ = true;
  }
  next_ = 0;
  for (Eigen::Matrix3d& block : blocks_) block.setZero();
}

void BlockMatrix::add(int row, int column, const Eigen::Matrix3d& block) {
  if (next_ < calls_.size()) {
    const Place& call = calls_[next_];
    if (call.row == row && call.column == column) {
      blocks_[static_cast<std::size_t>(call.block)] += block;
      ++next_;
      return;
    }
    calls_.resize(next_);
  }
  changed_ = true;
  ++next_;
  // A column holds a few dozen blocks at most: looking along beats any index.
  auto& places = columns_[static_cast<std::size_t>(column / 3)];
  auto place =
      std::find_if(places.begin(), places.end(), [&](const Place& own) { return own.row == row; });
  if (place == places.end()) {
    places.push_back({row, column, static_cast<int>(blocks_.size())});
    blocks_.emplace_back(Eigen::Matrix3d::Zero());
    place = places.end() - 1;
  }
  calls_.push_back(*place);
  blocks_[static_cast<std::size_t>(place->block)] += block;
}

/// Forgets the blocks that no call names, orders the others and lays out the compressed form.
void BlockMatrix::find_pattern() {
  std::vector<int> renamed(blocks_.size(), -1);
  for (const Place& call : calls_) renamed[static_cast<std::size_t>(call.block)] = 0;
  std::vector<Eigen::Matrix3d> ordered;
  outer_.assign(1, 0);
  inner_.clear();
  for (auto& places : columns_) {
    std::erase_if(
        places, [&](const Place& own) { return renamed[static_cast<std::size_t>(own.block)] < 0; });
    std::sort(places.begin(), places.end(),
              [](const Place& a, const Place& b) { return a.row < b.row; });
    for (int within = 0; within < 3; ++within) {
      for (const Place& place : places)
        for (int down = 0; down < 3; ++down) inner_.push_back(place.row + down);
      outer_.push_back(static_cast<int>(inner_.size()));
    }
    for (Place& place : places) {
      const auto old = static_cast<std::size_t>(place.block);
      renamed[old] = place.block = static_cast<int>(ordered.size());
      ordered.push_back(blocks_[old]);
    }
  }
  for (Place& call : calls_) call.block = renamed[static_cast<std::size_t>(call.block)];
  blocks_.swap(ordered);
  changed_ = false;
}

void BlockMatrix::write_to(Eigen::SparseMatrix<double>& matrix) {
  if (next_ < calls_.size()) {
    calls_.resize(next_);
    changed_ = true;
  }
  if (changed_) find_pattern();
  matrix.resize(size_, size_);
  matrix.resizeNonZeros(static_cast<Eigen::Index>(inner_.size()));
  std::copy(outer_.begin(), outer_.end(), matrix.outerIndexPtr());
  std::copy(inner_.begin(), inner_.end(), matrix.innerIndexPtr());
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const std::ptrdiff_t height = 3 * static_cast<std::ptrdiff_t>(columns_[i].size());
    double* first = matrix.valuePtr() + outer_[3 * i];
    for (const Place& place : columns_[i]) {
      const Eigen::Matrix3d& block = blocks_[static_cast<std::size_t>(place.block)];
      for (int within = 0; within < 3; ++within)
        for (int down = 0; down < 3; ++down) first[within * height + down] = block(down, within);
      first += 3;
    }
  }
}

}  // namespace stillgrid::dynamics
