#include "sim_server/dynamics/block_matrix.hpp"

#include <algorithm>

namespace stillgrid {

void BlockMatrix::reset(Eigen::Index size) {
  size_ = size;
  columns_.resize(static_cast<std::size_t>(size / 3));
  for (auto& column : columns_) column.clear();
}

void BlockMatrix::add(int row, int column, const Eigen::Matrix3d& block) {
  // A column holds a few dozen blocks at most: looking along beats any index.
  auto& entries = columns_[static_cast<std::size_t>(column / 3)];
  for (Entry& entry : entries)
    if (entry.row == row) {
      entry.block += block;
      return;
    }
  entries.push_back({row, block});
}

void BlockMatrix::write_to(Eigen::SparseMatrix<double>& matrix) {
  std::size_t blocks = 0;
  for (auto& entries : columns_) {
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.row < b.row; });
    blocks += entries.size();
  }
  matrix.resize(size_, size_);
  matrix.resizeNonZeros(static_cast<Eigen::Index>(9 * blocks));
  int filled = 0;
  for (std::size_t i = 0; i < columns_.size(); ++i)
    for (int within = 0; within < 3; ++within) {
      matrix.outerIndexPtr()[3 * i + static_cast<std::size_t>(within)] = filled;
      for (const Entry& entry : columns_[i])
        for (int down = 0; down < 3; ++down) {
          matrix.innerIndexPtr()[filled] = entry.row + down;
          matrix.valuePtr()[filled++] = entry.block(down, within);
        }
    }
  matrix.outerIndexPtr()[size_] = filled;
}

}  // namespace stillgrid
