#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <vector>

namespace stillgrid {

/// A sparse matrix of 3 x 3 blocks, gathered by sums. Memory is kept from one use to the next.
class BlockMatrix {
 public:
  /// Empties the matrix. Pre: size is a multiple of 3.
  void reset(Eigen::Index size);

  /// Adds to the block whose first row and column are given. Pre: both multiples of 3, below size.
  void add(int row, int column, const Eigen::Matrix3d& block);

  /// Writes the compressed form, rows ascending within each column.
  void write_to(Eigen::SparseMatrix<double>& matrix);

 private:
  struct Entry {
    int row;
    Eigen::Matrix3d block;
  };
  Eigen::Index size_ = 0;
  std::vector<std::vector<Entry>> columns_;  // of blocks
};

}  // namespace stillgrid
