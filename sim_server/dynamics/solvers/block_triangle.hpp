#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace stillgrid::dynamics {

/// A symmetric matrix A = L + D + L^T of 3 x 3 blocks that are symmetric themselves, as springs and
/// masses make it: its diagonal, and what lies below it row by row. Its places stay from one use to
/// the next, so that filling it allocates nothing.
///
/// Padded vectors have four numbers a block, the last of them zero, in the sweeps' order. Every
/// instruction set computes the same bytes. One thread.
class BlockTriangle {
 public:
  /// Two rows of blocks that something joins.
  struct Link {
    int a, b;
    bool operator==(const Link&) const = default;
  };

  /// Makes room for so many rows of blocks, joined so; what it held is lost. Links may repeat.
  /// Pre: a and b of each are different, not negative, below rows.
  void set_pattern(int rows, std::span<const Link> links);
  void set_zero();

  [[nodiscard]] int rows() const noexcept { return rows_; }

  /// The block of a row on the diagonal D.
  [[nodiscard]] Eigen::Map<Eigen::Matrix3d> diagonal(int row) {
    return Eigen::Map<Eigen::Matrix3d>(&diagonal_[9 * static_cast<std::size_t>(row)]);
  }
  [[nodiscard]] Eigen::Map<const Eigen::Matrix3d> diagonal(int row) const {
    return Eigen::Map<const Eigen::Matrix3d>(&diagonal_[9 * static_cast<std::size_t>(row)]);
  }
  /// The sum of all links between the two rows of a link, by its number in set_pattern().
  [[nodiscard]] Eigen::Map<Eigen::Matrix3d> below(std::size_t link) {
    return Eigen::Map<Eigen::Matrix3d>(&below_[9 * static_cast<std::size_t>(place_of_[link])]);
  }

  /// y = A x, neither padded.
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;

  /// Takes pivots E for a factorisation near a matrix that has `whole` for its diagonal, blocks
  /// side by side, and L below it: (E + L) E^-1 (E + L^T) with E = whole, symmetric successive
  /// over-relaxation. False, and no pivots, if a block is not positive definite.
  [[nodiscard]] bool factorise(const Eigen::Matrix3Xd& whole);

  /// y = (E + L)^-1 x. Pre: factorise() was true; padded; not the same.
  void solve_lower(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  /// y = (E + L^T)^-1 x, left = x + (D - 2 E) y. With E + L taken off both sides A is that, so
  ///   A y = (E + L) y + left   [Eisenstat 1981].
  void solve_upper(const Eigen::VectorXd& x, Eigen::VectorXd& y, Eigen::VectorXd& left) const;
  /// y = E x.
  void multiply_pivots(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;

  /// To a padded vector and from it; padded += vector.
  void pad(const Eigen::VectorXd& vector, Eigen::VectorXd& padded) const;
  void unpad(const Eigen::VectorXd& padded, Eigen::VectorXd& vector) const;
  void add_unpadded(const Eigen::VectorXd& vector, Eigen::VectorXd& padded) const;

 private:
  void order_rows();
  [[nodiscard]] int place_of_row(int row) const {
    return place_of_row_[static_cast<std::size_t>(row)];
  }

  int rows_ = 0;
  std::vector<Link> links_;
  std::vector<int> place_of_row_;    // in the order of the sweeps
  std::vector<int> place_of_;        // of each link: the block below the diagonal
  std::vector<bool> is_first_;       // of the links at its place
  std::vector<int> first_, column_;  // of each row in that order its first block; of each block
  std::vector<double> below_;        // nine numbers a block, and room for vectors to read on
  std::vector<double> diagonal_;     // nine numbers a row
  // Three columns of four a row: E, its inverse, and D - E.
  std::vector<double> pivot_, inverse_, apart_;
  mutable Eigen::VectorXd sum_;
};

}  // namespace stillgrid::dynamics
