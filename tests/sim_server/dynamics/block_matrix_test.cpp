#include "sim_server/dynamics/forces/block_matrix.hpp"

#include <Eigen/SparseLU>
#include <catch2/catch.hpp>
#include <random>

namespace stillgrid::dynamics::block_matrix_test {
namespace {

TEST_CASE("A block matrix is the sum of its blocks", "[block_matrix]") {
  constexpr int kBlocks = 7;
  std::mt19937 random(3);
  std::uniform_int_distribution<int> place(0, kBlocks - 1);
  BlockMatrix blocks;
  Eigen::SparseMatrix<double> sparse;
  for (int use = 0; use < 3; ++use) {  // nothing is left of the uses before
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * kBlocks, 3 * kBlocks);
    blocks.reset(3 * kBlocks);
    for (int i = 0; i < 40; ++i) {
      const int row = 3 * place(random), column = 3 * place(random);
      const Eigen::Matrix3d block = Eigen::Matrix3d::Random();
      blocks.add(row, column, block);
      dense.block<3, 3>(row, column) += block;
    }
    blocks.write_to(sparse);
    CHECK((Eigen::MatrixXd(sparse) - dense).norm() < 1e-14);
  }
}

TEST_CASE("Its sparse form is compressed, with rows in order", "[block_matrix]") {
  BlockMatrix blocks;
  blocks.reset(9);
  for (const int row : {6, 0, 3}) blocks.add(row, 3, Eigen::Matrix3d::Ones());
  Eigen::SparseMatrix<double> sparse;
  blocks.write_to(sparse);

  CHECK(sparse.isCompressed());
  CHECK(sparse.nonZeros() == 27);
  for (int column = 3; column < 6; ++column)
    for (int i = 0; i < 9; ++i)
      CHECK(sparse.innerIndexPtr()[sparse.outerIndexPtr()[column] + i] == i);
}

TEST_CASE("A matrix without rows is one too", "[block_matrix]") {
  BlockMatrix blocks;
  blocks.reset(0);
  Eigen::SparseMatrix<double> sparse;
  blocks.write_to(sparse);

  CHECK(sparse.rows() == 0);
  CHECK(sparse.nonZeros() == 0);
}

}  // namespace
}  // namespace stillgrid::dynamics::block_matrix_test
