#include "shared/collision/distance_field.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "proto/segment_header.hpp"
#include "shared/collision/exact_shape.hpp"
#include "shared/double_buffer/double_buffer.hpp"

namespace stillgrid::collision {
namespace {

constexpr std::uint32_t kMaxBricks = 4096;  // along an axis
constexpr std::uint64_t kMaxBricksInAll = 1U << 25U;
/// A spline of a distance has no longer gradient, nor is a map of stiffness steeper than it is
/// high.
constexpr double kSteepest = 2.0;
constexpr double kStiffest = 1e3;  // of a map, but for what sums round

std::size_t words_of(std::uint64_t numbers) {
  return static_cast<std::size_t>((numbers + 1) / 2);
}

double load_float(const std::uint64_t* words, std::size_t index) {
  return static_cast<double>(std::bit_cast<float>(double_buffer::load_u32(words, index)));
}

/// The three coefficients that count in a cell, of a quadratic B-spline, and their slopes.
struct Weights {
  std::array<double, 3> value, slope;
  explicit Weights(double t) noexcept
      : value{0.5 * (1.0 - t) * (1.0 - t), 0.75 - (t - 0.5) * (t - 0.5), 0.5 * t * t},
        slope{t - 1.0, 1.0 - 2.0 * t, t} {}
};

/// A scalar and its derivative in cells.
struct Jet {
  double value = 0.0;
  Eigen::Vector3d slope = Eigen::Vector3d::Zero();
};

/// Of the coefficients from `first` on, along the axes so many numbers apart.
Jet spline(const std::uint64_t* words, std::size_t first, std::size_t row, std::size_t layer,
           const Eigen::Vector3d& place) noexcept {
  const Weights x(place.x()), y(place.y()), z(place.z());
  Jet jet;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t j = 0; j < 3; ++j) {
      double value = 0.0, slope = 0.0;
      for (std::size_t i = 0; i < 3; ++i) {
        const double coefficient = load_float(words, first + k * layer + j * row + i);
        value += x.value[i] * coefficient;
        slope += x.slope[i] * coefficient;
      }
      jet.value += z.value[k] * y.value[j] * value;
      jet.slope.x() += z.value[k] * y.value[j] * slope;
      jet.slope.y() += z.value[k] * y.slope[j] * value;
      jet.slope.z() += z.slope[k] * y.value[j] * value;
    }
  return jet;
}

/// Of an array of one number a brick and a layer round them.
Jet coarse_spline(const FieldView& field, std::size_t array, const Eigen::Array3i& brick,
                  const Eigen::Vector3d& place) noexcept {
  const std::size_t row = field.shape.bricks[0] + 2;
  const std::size_t layer = row * (field.shape.bricks[1] + 2);
  const auto at = brick.cast<std::size_t>();
  return spline(field.words + array, at.x() + row * at.y() + layer * at.z(), row, layer, place);
}

}  // namespace

FieldCounts field_counts(const proto::FieldShape& shape) noexcept {
  if (is_exact(shape)) return {};
  const auto [x, y, z] = shape.bricks;
  const std::size_t coarse = std::size_t{x + 2} * (y + 2) * (z + 2);
  return {.coarse = coarse,
          .numbers = std::size_t{x} * y * z,
          .stiffness = shape.has_stiffness != 0 ? coarse : 0,
          .fine = std::size_t{shape.fine_count} * proto::kBrickCoefficients};
}

FieldLayout field_layout(const proto::FieldShape& shape) noexcept {
  const FieldCounts counts = field_counts(shape);
  FieldLayout layout;
  layout.numbers = layout.coarse + words_of(counts.coarse);
  layout.stiffness = layout.numbers + words_of(counts.numbers);
  layout.fine = layout.stiffness + words_of(counts.stiffness);
  layout.total_words = layout.fine + words_of(counts.fine);
  return layout;
}

bool is_consistent(const proto::FieldShape& shape) noexcept {
  if (is_exact(shape)) return is_consistent_exact(shape);
  std::uint64_t all = 1;
  for (const std::uint32_t bricks : shape.bricks) {
    if (bricks == 0 || bricks > kMaxBricks) return false;
    all *= bricks;
  }
  // Written so that a NaN does not pass.
  bool sound = all <= kMaxBricksInAll && shape.fine_count <= all && shape.has_stiffness <= 1 &&
               shape.brick_m > 0.0F && shape.brick_m <= proto::kLargestNumber &&
               shape.bounding_radius_m > 0.0F && shape.bounding_radius_m <= proto::kLargestNumber;
  for (std::size_t i = 0; i < 3; ++i)
    sound = sound && std::abs(shape.lowest_m[i]) <= proto::kLargestNumber &&
            std::abs(shape.centre_m[i]) <= proto::kLargestNumber;
  return sound;
}

double detail_m(const proto::FieldShape& shape) noexcept {
  if (!is_exact(shape)) return double{shape.brick_m} / proto::kBrickCells;
  return half_sides_m(shape).minCoeff();
}

std::optional<FieldSample> sample(const FieldView& field, const Eigen::Vector3d& point_m) noexcept {
  const proto::FieldShape& shape = field.shape;
  if (is_exact(shape)) return exact_sample(shape, point_m);
  const Eigen::Array3d lowest_m =
      Eigen::Map<const Eigen::Array3f>(shape.lowest_m.data()).cast<double>();
  const double per_m = 1.0 / double{shape.brick_m};
  const Eigen::Array3d place = (point_m.array() - lowest_m) * per_m;
  const auto [x, y, z] = shape.bricks;
  // Written so that a NaN does not pass.
  if (!((place >= 0.0).all() && place.x() < x && place.y() < y && place.z() < z))
    return std::nullopt;
  const Eigen::Array3i brick = place.cast<int>();
  const Eigen::Array3d within = place - brick.cast<double>();
  const auto at = brick.cast<std::size_t>();
  const std::uint32_t number = double_buffer::load_u32(
      field.words + field.layout.numbers, at.x() + x * (at.y() + std::size_t{y} * at.z()));
  FieldSample result;
  if (number == 0 || number > shape.fine_count) {
    const Jet jet = coarse_spline(field, field.layout.coarse, brick, within);
    result.distance_m = jet.value;
    result.gradient = per_m * jet.slope;
  } else {
    const Eigen::Array3d fine = within * double{proto::kBrickCells};
    const Eigen::Array3i cell = fine.cast<int>().min(int{proto::kBrickCells} - 1);
    const auto c = cell.cast<std::size_t>();
    constexpr std::size_t kRow = proto::kBrickNodes, kLayer = kRow * kRow;
    const Jet jet = spline(
        field.words + field.layout.fine,
        std::size_t{number - 1} * proto::kBrickCoefficients + c.x() + kRow * c.y() + kLayer * c.z(),
        kRow, kLayer, fine - cell.cast<double>());
    result.distance_m = jet.value;
    result.gradient = per_m * proto::kBrickCells * jet.slope;
  }
  if (shape.has_stiffness != 0) {
    const Jet jet = coarse_spline(field, field.layout.stiffness, brick, within);
    result.stiffness_scale = jet.value;
    result.stiffness_gradient_per_m = per_m * jet.slope;
  }
  return result;
}

std::optional<FieldContact> field_contact(const FieldView& field, const Eigen::Vector3d& centre_m,
                                          double radius_m) noexcept {
  const std::optional<FieldSample> at = sample(field, centre_m);
  const auto& bricks = field.shape.bricks;
  const double longest_m =
      is_exact(field.shape) ? std::numeric_limits<double>::max()
                            : 4.0 * double{field.shape.bounding_radius_m} +
                                  double{field.shape.brick_m} * (bricks[0] + bricks[1] + bricks[2]);
  // Written so that a NaN does not pass.
  if (!at || !(std::abs(at->distance_m) <= longest_m) || !(at->gradient.norm() <= kSteepest) ||
      !(at->stiffness_scale >= 0.0 && at->stiffness_scale <= kStiffest + 1.0) ||
      !at->stiffness_gradient_per_m.allFinite())
    return std::nullopt;
  const double depth_m = radius_m - at->distance_m;
  Eigen::Vector3d force_m = at->stiffness_scale * at->gradient;
  if (depth_m > 0.0) force_m -= 0.5 * depth_m * at->stiffness_gradient_per_m;
  const double size = force_m.norm();
  // Written so that a NaN does not pass. Beyond a map's bound the force grows no more: to let go
  // there would drop what is pressed deeper.
  if (!(size > 1e-9 && std::isfinite(size))) return std::nullopt;
  const double scale = std::min(size, 2.0 * kSteepest * kStiffest);
  return FieldContact{depth_m, force_m / size, scale, at->stiffness_scale};
}

FieldContact flat_contact(const FieldView& field, const FieldContact& at_proxy,
                          const Eigen::Vector3d& proxy_m, const Eigen::Vector3d& device_m,
                          double radius_m) noexcept {
  constexpr double kSteeper = 1.1, kSameFace = 0.5;
  const auto slope = [](const FieldContact& at) { return at.stiffness_scale / at.map_scale; };
  const auto there = field_contact(field, device_m, radius_m);
  const bool is_there = there && there->normal.dot(at_proxy.normal) > kSameFace &&
                        slope(*there) > kSteeper * slope(at_proxy);
  const Eigen::Vector3d& at_m = is_there ? device_m : proxy_m;
  FieldContact contact = is_there ? *there : at_proxy;
  const Eigen::Vector3d foot_m = at_m - (radius_m - contact.depth_m) * contact.normal;
  if (const auto foot = field_contact(field, foot_m, 0.0)) contact.depth_m += foot->depth_m;
  contact.depth_m -= contact.normal.dot(proxy_m - at_m);
  return contact;
}

DistanceField::DistanceField(const proto::FieldShape& shape, std::vector<std::uint64_t> words)
    : shape_(shape), layout_(field_layout(shape)), words_(std::move(words)) {
  assert(is_consistent(shape_) && words_.size() == layout_.total_words);
}

}  // namespace stillgrid::collision
