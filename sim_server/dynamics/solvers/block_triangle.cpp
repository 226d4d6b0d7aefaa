#include "sim_server/dynamics/solvers/block_triangle.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/dynamics/solvers/block_triangle.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#ifndef STILLGRID_BLOCK_TRIANGLE_ONCE
#define STILLGRID_BLOCK_TRIANGLE_ONCE
namespace stillgrid::dynamics {
namespace {

constexpr std::size_t kPadded = 4;       // numbers of a padded block
constexpr std::size_t kColumns = 12;     // of three padded columns
constexpr std::size_t kReadBeyond = 16;  // numbers after the last block that a load may touch

/// What the sweeps read.
struct Rows {
  std::size_t count;
  const int *first, *column;
  const double *below, *inverse, *apart;
};

}  // namespace
}  // namespace stillgrid::dynamics
#endif

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, kPadded>;
using Vec = hn::Vec<Tag>;

/// Lanes from k on of block * x, where columns begin `stride` apart. Never fused, so that targets
/// without fused products round alike.
HWY_INLINE Vec Product(const double* HWY_RESTRICT block, std::size_t stride, std::size_t k, Vec x,
                       Vec y, Vec z) {
  const Tag d;
  return hn::Add(
      hn::Add(hn::Mul(hn::LoadU(d, block + k), x), hn::Mul(hn::LoadU(d, block + stride + k), y)),
      hn::Mul(hn::LoadU(d, block + 2 * stride + k), z));
}

/// to = columns * from, all padded.
HWY_INLINE void Apply(const double* HWY_RESTRICT columns, const double* HWY_RESTRICT from,
                      double* HWY_RESTRICT to) {
  const Tag d;
  const Vec x = hn::Set(d, from[0]), y = hn::Set(d, from[1]), z = hn::Set(d, from[2]);
  for (std::size_t k = 0; k < kPadded; k += hn::Lanes(d))
    hn::StoreU(Product(columns, kPadded, k, x, y, z), d, to + k);
}

void SweepDown(const Rows& rows, const double* HWY_RESTRICT from, double* HWY_RESTRICT to) {
  const Tag d;
  for (std::size_t i = 0; i < rows.count; ++i) {
    const auto begin = static_cast<std::size_t>(rows.first[i]);
    const auto end = static_cast<std::size_t>(rows.first[i + 1]);
    HWY_ALIGN double sum[kPadded];
    for (std::size_t k = 0; k < kPadded; k += hn::Lanes(d)) {
      Vec left = hn::LoadU(d, from + kPadded * i + k);
      for (std::size_t e = begin; e < end; ++e) {
        const double* const x = to + kPadded * static_cast<std::size_t>(rows.column[e]);
        left = hn::Sub(left, Product(rows.below + 9 * e, 3, k, hn::Set(d, x[0]), hn::Set(d, x[1]),
                                     hn::Set(d, x[2])));
      }
      hn::StoreU(left, d, sum + k);
    }
    Apply(rows.inverse + kColumns * i, sum, to + kPadded * i);
  }
}

/// sum: from, of which the sweep makes E + L^T times `to` row by row.
void SweepUp(const Rows& rows, const double* HWY_RESTRICT from, double* HWY_RESTRICT sum,
             double* HWY_RESTRICT to, double* HWY_RESTRICT left) {
  const Tag d;
  for (std::size_t i = rows.count; i-- > 0;) {
    double* const own = to + kPadded * i;
    Apply(rows.inverse + kColumns * i, sum + kPadded * i, own);
    const Vec x = hn::Set(d, own[0]), y = hn::Set(d, own[1]), z = hn::Set(d, own[2]);
    for (std::size_t k = 0; k < kPadded; k += hn::Lanes(d)) {
      const Vec rest =
          hn::Sub(hn::LoadU(d, from + kPadded * i + k), hn::LoadU(d, sum + kPadded * i + k));
      hn::StoreU(hn::Add(rest, Product(rows.apart + kColumns * i, kPadded, k, x, y, z)), d,
                 left + kPadded * i + k);
      const auto begin = static_cast<std::size_t>(rows.first[i]);
      const auto end = static_cast<std::size_t>(rows.first[i + 1]);
      for (std::size_t e = begin; e < end; ++e) {
        double* const other = sum + kPadded * static_cast<std::size_t>(rows.column[e]) + k;
        hn::StoreU(hn::Sub(hn::LoadU(d, other), Product(rows.below + 9 * e, 3, k, x, y, z)), d,
                   other);
      }
    }
    left[kPadded * i + 3] = 0.0;
  }
}

void ApplyAll(std::size_t rows, const double* HWY_RESTRICT columns, const double* HWY_RESTRICT from,
              double* HWY_RESTRICT to) {
  for (std::size_t i = 0; i < rows; ++i)
    Apply(columns + kColumns * i, from + kPadded * i, to + kPadded * i);
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {
namespace {
HWY_EXPORT(SweepDown);
HWY_EXPORT(SweepUp);
HWY_EXPORT(ApplyAll);

bool is_definite(const Eigen::Matrix3d& block, double determinant) {
  return block(0, 0) > 0.0 && block(0, 0) * block(1, 1) - block(0, 1) * block(1, 0) > 0.0 &&
         determinant > 0.0 && std::isfinite(determinant);
}

auto columns_at(std::vector<double>& columns, std::size_t row) {
  return Eigen::Map<Eigen::Matrix3d, 0, Eigen::OuterStride<4>>(&columns[kColumns * row]);
}

}  // namespace

void BlockTriangle::set_pattern(int rows, std::span<const Link> links) {
  if (rows == rows_ && std::ranges::equal(links, links_)) return;
  rows_ = rows;
  links_.assign(links.begin(), links.end());
  order_rows();
  struct Place {
    int row, column;
    std::size_t link;
  };
  std::vector<Place> places;
  places.reserve(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const int a = place_of_row(links[i].a), b = place_of_row(links[i].b);
    places.push_back({std::max(a, b), std::min(a, b), i});
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.row != b.row ? a.row < b.row : a.column < b.column;
  });
  first_.assign(static_cast<std::size_t>(rows) + 1, 0);
  column_.clear();
  place_of_.resize(links.size());
  is_first_.resize(links.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& own = places[i];
    if (i == 0 || own.row != places[i - 1].row || own.column != places[i - 1].column) {
      column_.push_back(own.column);
      ++first_[static_cast<std::size_t>(own.row) + 1];
    }
    place_of_[own.link] = static_cast<int>(column_.size()) - 1;
    is_first_[own.link] =
        i == 0 || own.row != places[i - 1].row || own.column != places[i - 1].column;
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  const auto count = static_cast<std::size_t>(rows);
  below_.assign(9 * column_.size() + kReadBeyond, 0.0);
  diagonal_.assign(9 * count, 0.0);
  for (std::vector<double>* own : {&pivot_, &inverse_, &apart_}) own->assign(kColumns * count, 0.0);
  sum_.setZero(static_cast<Eigen::Index>(kPadded * count));
}

/// By how many rows lead to each, one after the other: rows beside each other then seldom wait for
/// one another, and a sweep gives what it gave in the order of their numbers.
void BlockTriangle::order_rows() {
  const auto count = static_cast<std::size_t>(rows_);
  std::vector<std::vector<int>> before(count);
  for (const Link& link : links_)
    before[static_cast<std::size_t>(std::max(link.a, link.b))].push_back(std::min(link.a, link.b));
  std::vector<int> level(count, 0), order(count);
  for (std::size_t row = 0; row < count; ++row)
    for (const int earlier : before[row])
      level[row] = std::max(level[row], level[static_cast<std::size_t>(earlier)] + 1);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return level[static_cast<std::size_t>(a)] < level[static_cast<std::size_t>(b)];
  });
  place_of_row_.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    place_of_row_[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
}

void BlockTriangle::set_zero() {
  std::fill(below_.begin(), below_.end(), 0.0);
  std::fill(diagonal_.begin(), diagonal_.end(), 0.0);
}

void BlockTriangle::multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  y.resize(x.size());
  for (int row = 0; row < rows_; ++row)
    y.segment<3>(3 * row).noalias() = diagonal(row) * x.segment<3>(3 * row);
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const auto place = static_cast<std::size_t>(place_of_[i]);
    if (!is_first_[i]) continue;  // of several at one place, which has their sum
    const Eigen::Map<const Eigen::Matrix3d> block(&below_[9 * place]);
    const int a = 3 * links_[i].a, b = 3 * links_[i].b;
    y.segment<3>(a).noalias() += block * x.segment<3>(b);
    y.segment<3>(b).noalias() += block * x.segment<3>(a);
  }
}

bool BlockTriangle::factorise(const Eigen::Matrix3Xd& whole) {
  for (int row = 0; row < rows_; ++row) {
    const auto at = static_cast<std::size_t>(place_of_row(row));
    const Eigen::Matrix3d pivot = whole.middleCols<3>(3 * row);
    const double determinant = pivot.determinant();
    // A matrix is no more definite than its blocks.
    if (!is_definite(pivot, determinant)) return false;
    columns_at(pivot_, at) = pivot;
    columns_at(inverse_, at) = pivot.inverse();
    columns_at(apart_, at) = diagonal(row) - pivot;
  }
  return true;
}

void BlockTriangle::solve_lower(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  y.resize(x.size());
  const Rows rows{static_cast<std::size_t>(rows_),
                  first_.data(),
                  column_.data(),
                  below_.data(),
                  inverse_.data(),
                  apart_.data()};
  HWY_DYNAMIC_DISPATCH(SweepDown)(rows, x.data(), y.data());
}

void BlockTriangle::solve_upper(const Eigen::VectorXd& x, Eigen::VectorXd& y,
                                Eigen::VectorXd& left) const {
  y.resize(x.size());
  left.resize(x.size());
  sum_ = x;
  const Rows rows{static_cast<std::size_t>(rows_),
                  first_.data(),
                  column_.data(),
                  below_.data(),
                  inverse_.data(),
                  apart_.data()};
  HWY_DYNAMIC_DISPATCH(SweepUp)(rows, x.data(), sum_.data(), y.data(), left.data());
}

void BlockTriangle::multiply_pivots(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  y.resize(x.size());
  HWY_DYNAMIC_DISPATCH(ApplyAll)
  (static_cast<std::size_t>(rows_), pivot_.data(), x.data(), y.data());
}

void BlockTriangle::pad(const Eigen::VectorXd& vector, Eigen::VectorXd& padded) const {
  padded.resize(4 * rows_);
  for (int row = 0; row < rows_; ++row)
    padded.segment<4>(4 * place_of_row(row)) << vector.segment<3>(3 * row), 0.0;
}

void BlockTriangle::unpad(const Eigen::VectorXd& padded, Eigen::VectorXd& vector) const {
  vector.resize(3 * rows_);
  for (int row = 0; row < rows_; ++row)
    vector.segment<3>(3 * row) = padded.segment<3>(4 * place_of_row(row));
}

void BlockTriangle::add_unpadded(const Eigen::VectorXd& vector, Eigen::VectorXd& padded) const {
  for (int row = 0; row < rows_; ++row)
    padded.segment<3>(4 * place_of_row(row)) += vector.segment<3>(3 * row);
}

}  // namespace stillgrid::dynamics
#endif
