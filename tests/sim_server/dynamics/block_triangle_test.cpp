#include "sim_server/dynamics/solvers/block_triangle.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <vector>

#include "tests/sim_server/every_target.hpp"

namespace stillgrid::dynamics::block_triangle_test {
namespace {

constexpr int kRows = 37;

/// Rows joined to some before and after them, a few twice, as springs of a body join its nodes.
std::vector<BlockTriangle::Link> some_links() {
  std::mt19937 random(3);
  std::vector<BlockTriangle::Link> links;
  for (int row = 1; row < kRows; ++row)
    for (int k = 0; k < 4; ++k) {
      const int other = static_cast<int>(random() % static_cast<unsigned>(row));
      links.push_back(k % 2 == 0 ? BlockTriangle::Link{row, other}
                                 : BlockTriangle::Link{other, row});
    }
  return links;
}

struct Filled {
  BlockTriangle triangle;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3 * kRows, 3 * kRows);
  Eigen::MatrixXd lower = matrix;  // below the diagonal, in the order of the rows' numbers
  Eigen::Matrix3Xd whole =
      Eigen::Matrix3Xd::Zero(3, 3 * kRows);  // with what is not in the triangle
};

Filled filled() {
  Filled filled;
  const std::vector<BlockTriangle::Link> links = some_links();
  filled.triangle.set_pattern(kRows, links);
  filled.triangle.set_zero();
  std::srand(5);  // Eigen's
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Eigen::Vector3d line = Eigen::Vector3d::Random();
    const Eigen::Matrix3d block = line * line.transpose() + 0.1 * Eigen::Matrix3d::Identity();
    const int a = 3 * links[i].a, b = 3 * links[i].b;
    filled.triangle.below(i) -= block;
    filled.matrix.block<3, 3>(a, b) -= block;
    filled.matrix.block<3, 3>(b, a) -= block;
    filled.lower.block<3, 3>(std::max(a, b), std::min(a, b)) -= block;
    for (const int row : {a, b}) {
      filled.triangle.diagonal(row / 3) += block;
      filled.matrix.block<3, 3>(row, row) += block;
    }
  }
  for (int row = 0; row < kRows; ++row) {
    filled.triangle.diagonal(row) += 0.3 * Eigen::Matrix3d::Identity();
    filled.matrix.block<3, 3>(3 * row, 3 * row) += 0.3 * Eigen::Matrix3d::Identity();
    filled.whole.middleCols<3>(3 * row) = filled.matrix.block<3, 3>(3 * row, 3 * row);
  }
  filled.whole.middleCols<3>(6) += 2.0 * Eigen::Matrix3d::Identity();  // as a contact's
  return filled;
}

Eigen::VectorXd numbers() {
  std::srand(7);
  return Eigen::VectorXd::Random(3 * kRows);
}

}  // namespace

TEST_CASE("A block triangle is the matrix that was put into it", "[block_triangle]") {
  const Filled filled = block_triangle_test::filled();
  const Eigen::VectorXd x = numbers();
  Eigen::VectorXd product, padded, back;
  filled.triangle.multiply(x, product);
  CHECK((product - filled.matrix * x).norm() < 1e-14 * product.norm());
  filled.triangle.pad(x, padded);
  filled.triangle.unpad(padded, back);
  CHECK(back == x);
}

TEST_CASE("Two sweeps of a block triangle are a product between its factors", "[block_triangle]") {
  Filled filled = block_triangle_test::filled();
  REQUIRE(filled.triangle.factorise(filled.whole));
  Eigen::MatrixXd lower = filled.lower;  // E + L
  for (int row = 0; row < kRows; ++row)
    lower.block<3, 3>(3 * row, 3 * row) = filled.whole.middleCols<3>(3 * row);
  const Eigen::VectorXd x = numbers();
  const Eigen::VectorXd y = lower.transpose().fullPivLu().solve(x);
  const Eigen::VectorXd whole = lower.fullPivLu().solve(filled.matrix * y);
  const Eigen::VectorXd pivots = lower.fullPivLu().solve(x);

  std::optional<Eigen::VectorXd> first;
  sim_server::on_every_target([&] {
    Eigen::VectorXd padded, upper, left, down, result;
    filled.triangle.pad(x, padded);
    filled.triangle.solve_upper(padded, upper, left);
    filled.triangle.unpad(upper, result);
    CHECK((result - y).norm() < 1e-12 * y.norm());
    filled.triangle.solve_lower(left, down);
    down += upper;
    filled.triangle.unpad(down, result);
    CHECK((result - whole).norm() < 1e-12 * whole.norm());
    filled.triangle.solve_lower(padded, down);
    filled.triangle.unpad(down, result);
    CHECK((result - pivots).norm() < 1e-12 * pivots.norm());
    for (Eigen::Index i = 3; i < upper.size(); i += 4) CHECK((upper[i] == 0.0 && left[i] == 0.0));
    if (!first) first = left;
    CHECK(std::memcmp(first->data(), left.data(),
                      sizeof(double) * static_cast<std::size_t>(left.size())) == 0);
  });
}

TEST_CASE("A block that is not positive definite gives no factors", "[block_triangle]") {
  Filled filled = block_triangle_test::filled();
  filled.whole(1, 3 * 11 + 1) = -0.1;
  CHECK_FALSE(filled.triangle.factorise(filled.whole));
}

}  // namespace stillgrid::dynamics::block_triangle_test
