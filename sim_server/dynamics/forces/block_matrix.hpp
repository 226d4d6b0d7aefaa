#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <vector>

namespace stillgrid::dynamics {

/// A sparse matrix of 3 x 3 blocks, gathered by sums. Where the blocks go is kept from one use to
/// the next: one that adds at the same places in the same order writes straight to them.
class BlockMatrix {
 public:
  /// Makes the matrix zero. Pre: size is a multiple of 3.
  void reset(Eigen::Index size);

  /// Adds to the block whose first row and column are given. Pre: both multiples of 3, below size.
  void add(int row, int column, const Eigen::Matrix3d& block);

  /// Writes the compressed form, rows ascending within each column: the places added to since
  /// reset().
  void write_to(Eigen::SparseMatrix<double>& matrix);

 private:
  struct Place {
    int row, column, block;  // index into blocks_
    bool operator==(const Place&) const = default;
  };
  void find_pattern();

  Eigen::Index size_ = 0;
  std::vector<Place> calls_;                 // of add(), in their order
  std::size_t next_ = 0;                     // of them to come
  bool changed_ = false;                     // the calls differ from those before
  std::vector<std::vector<Place>> columns_;  // of blocks: where each is
  std::vector<Eigen::Matrix3d> blocks_;
  std::vector<int> outer_, inner_;  // of the compressed form
};

}  // namespace stillgrid::dynamics
