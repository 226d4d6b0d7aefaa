#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/collision/distance_field.hpp"

namespace stillgrid::collision {
namespace {

using Index = Eigen::Array3i;
constexpr int kCells = static_cast<int>(proto::kBrickCells);
constexpr int kNodes = static_cast<int>(proto::kBrickNodes);

/// What a quadratic spline's coefficients become when each cell is halved twice: of the cell
/// before, the cell itself and the one behind it, for each of its four parts.
constexpr std::array<std::array<double, 3>, proto::kBrickCells> kRefined = {
    {{6.0 / 16.0, 10.0 / 16.0, 0.0},
     {3.0 / 16.0, 12.0 / 16.0, 1.0 / 16.0},
     {1.0 / 16.0, 12.0 / 16.0, 3.0 / 16.0},
     {0.0, 10.0 / 16.0, 6.0 / 16.0}}};

template <class Visit>
void for_each(const Index& from, const Index& to, Visit&& visit) {
  for (int z = from.z(); z < to.z(); ++z)
    for (int y = from.y(); y < to.y(); ++y)
      for (int x = from.x(); x < to.x(); ++x) visit(Index(x, y, z));
}

constexpr std::size_t kBrickOwn =
    std::size_t{proto::kBrickCells} * proto::kBrickCells * proto::kBrickCells;
constexpr double kBrickBytes = proto::kBrickCoefficients * sizeof(float);

[[noreturn]] void refuse_size(double bytes) {
  throw std::invalid_argument(
      "a field of at least " + std::to_string(static_cast<long>(bytes / 1048576.0)) +
      " MiB: expected at most " + std::to_string(kMaxFieldBytes / 1048576) + " MiB: wider cells");
}

/// A quadratic spline's coefficient from samples, such that it goes through every quadratic
/// function, which it would smooth with samples for coefficients: (10 f - f before - f behind) / 8
/// along an axis [Sablonniere 2005]. beside(axis, step): the sample a step along an axis.
template <class Beside>
float sharpened(float here, Beside&& beside) {
  double differences = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    for (const int step : {-1, 1}) differences += double{beside(axis, step)} - double{here};
  return static_cast<float>(double{here} - 0.125 * differences);
}

/// Fills a field's arrays. Its words are floats and numbers in pairs.
class FieldMaker {
 public:
  FieldMaker(const Eigen::AlignedBox3d& solid_m, const FieldFineness& fineness,
             const ScalarField& distance)
      : distance_(distance) {
    const double brick_m = kCells * fineness.cell_m, margin_m = fineness.margin_m;
    const Eigen::Array3d sides_m = solid_m.sizes().array() + 2.0 * margin_m;
    const Eigen::Array3d bricks = (sides_m / brick_m).ceil().max(1.0);
    if (!(bricks.prod() * 8.0 <= static_cast<double>(kMaxFieldBytes)) || !(bricks <= 4096.0).all())
      refuse_size(bricks.prod() * 8.0);
    bricks_ = bricks.cast<int>();
    shape_.brick_m = static_cast<float>(brick_m);
    // In the middle, so that a solid that is symmetric has a field that is.
    const Eigen::Vector3f lowest_m =
        (solid_m.center().array() - 0.5 * brick_m * bricks).cast<float>();
    const Eigen::Vector3f centre_m = solid_m.center().cast<float>();
    for (std::size_t i = 0; i < 3; ++i) {
      shape_.lowest_m[i] = lowest_m[static_cast<int>(i)];
      shape_.centre_m[i] = centre_m[static_cast<int>(i)];
      shape_.bricks[i] = static_cast<std::uint32_t>(bricks_[static_cast<int>(i)]);
    }
    shape_.bounding_radius_m = static_cast<float>(0.5 * solid_m.sizes().norm()) * 1.00001F;
    take_coarse(fineness.band_m);
  }

  DistanceField make(const ScalarField& stiffness) {
    shape_.has_stiffness = stiffness ? 1 : 0;
    const FieldLayout layout = field_layout(shape_);
    if (layout.total_words * 8 > kMaxFieldBytes)
      refuse_size(static_cast<double>(layout.total_words) * 8.0);
    words_.assign(layout.total_words, 0);
    for (std::size_t i = 0; i < coarse_.size(); ++i) put(layout.coarse, i, coarse_[i]);
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      put(layout.numbers, i, std::bit_cast<float>(numbers_[i]));
    if (stiffness) {
      std::size_t i = 0;
      for_each(Index::Constant(-1), bricks_ + 1, [&](const Index& brick) {
        const double scale = stiffness(middle_m(brick, 1.0));
        if (!(scale > 0.0 && scale <= 1e3))
          throw std::invalid_argument("stiffness over the material's: " + std::to_string(scale) +
                                      ": expected more than 0, at most 1000");
        put(layout.stiffness, i++, static_cast<float>(scale));
      });
    }
    take_own(layout);
    take_aprons(layout);
    return DistanceField(shape_, std::move(words_));
  }

 private:
  [[nodiscard]] Eigen::Vector3d middle_m(const Index& cell, double cells_a_brick) const {
    const Eigen::Array3d lowest_m =
        Eigen::Map<const Eigen::Array3f>(shape_.lowest_m.data()).cast<double>();
    return lowest_m + (cell.cast<double>() + 0.5) * (double{shape_.brick_m} / cells_a_brick);
  }
  [[nodiscard]] float distance_at(const Eigen::Vector3d& point_m) const {
    const double distance_m = distance_(point_m);
    if (!std::isfinite(distance_m)) throw std::invalid_argument("a distance that is no number");
    return static_cast<float>(distance_m);
  }
  [[nodiscard]] std::size_t coarse_place(const Index& brick) const {
    const Index at = brick + 1, sides = bricks_ + 2;
    return static_cast<std::size_t>(at.x()) +
           static_cast<std::size_t>(sides.x()) *
               (static_cast<std::size_t>(at.y()) +
                static_cast<std::size_t>(sides.y()) * static_cast<std::size_t>(at.z()));
  }
  /// Of a brick's fine coefficients, from 1; 0: it has none.
  [[nodiscard]] std::uint32_t number_of(const Index& brick) const {
    if ((brick < 0).any() || (brick >= bricks_).any()) return 0;
    return numbers_[static_cast<std::size_t>(brick.x()) +
                    static_cast<std::size_t>(bricks_.x()) *
                        (static_cast<std::size_t>(brick.y()) +
                         static_cast<std::size_t>(bricks_.y()) *
                             static_cast<std::size_t>(brick.z()))];
  }
  void put(std::size_t array, std::size_t index, float value) {
    auto* const numbers = reinterpret_cast<std::byte*>(words_.data() + array);
    std::memcpy(numbers + 4 * index, &value, 4);
  }
  [[nodiscard]] float get(std::size_t array, std::size_t index) const {
    float value = 0.0F;
    std::memcpy(&value, reinterpret_cast<const std::byte*>(words_.data() + array) + 4 * index, 4);
    return value;
  }
  /// Of the cell that many from the brick's first, -1 to kCells.
  static std::size_t node(std::uint32_t number, const Index& cell) {
    const Index at = cell + 1;
    return std::size_t{number - 1} * proto::kBrickCoefficients +
           static_cast<std::size_t>(at.x() + kNodes * (at.y() + kNodes * at.z()));
  }

  void take_coarse(double band_m) {
    // Of what lies within the band no coefficient is of a cell beside a coarse brick.
    const double within_m = band_m + (0.5 + 2.5 / kCells) * std::sqrt(3.0) * double{shape_.brick_m};
    const Index sides = bricks_ + 4;  // two layers round all bricks
    const auto place = [&](const Index& brick) {
      const auto at = (brick + 2).cast<std::size_t>();
      const auto side = sides.cast<std::size_t>();
      return at.x() + side.x() * (at.y() + side.y() * at.z());
    };
    std::vector<float> exact;
    exact.reserve(static_cast<std::size_t>(sides.prod()));
    for_each(Index::Constant(-2), bricks_ + 2, [&](const Index& brick) {
      exact.push_back(distance_at(middle_m(brick, 1.0)));
      if ((brick < 0).any() || (brick >= bricks_).any()) return;
      const bool is_fine = std::abs(double{exact.back()}) <= within_m;
      numbers_.push_back(is_fine ? ++shape_.fine_count : 0);
      const double bytes = kBrickBytes * static_cast<double>(shape_.fine_count);
      if (bytes > static_cast<double>(kMaxFieldBytes)) refuse_size(bytes);
    });
    for_each(Index::Constant(-1), bricks_ + 1, [&](const Index& brick) {
      coarse_.push_back(sharpened(exact[place(brick)], [&](int axis, int step) {
        Index beside = brick;
        beside[axis] += step;
        return exact[place(beside)];
      }));
    });
  }

  /// The coarse spline's coefficient for a cell, refined; of a cell beside the field too.
  [[nodiscard]] float refined(const Index& brick, const Index& cell) const {
    double sum = 0.0;
    for_each(Index::Zero(), Index::Constant(3), [&](const Index& k) {
      double weight = 1.0;
      for (int i = 0; i < 3; ++i)
        weight *= kRefined[static_cast<std::size_t>(cell[i])][static_cast<std::size_t>(k[i])];
      if (weight > 0.0) sum += weight * double{coarse_[coarse_place(brick + k - 1)]};
    });
    return static_cast<float>(sum);
  }
  /// Whether a cell of a fine brick touches one that has no finer coefficients.
  [[nodiscard]] bool is_at_border(const Index& brick, const Index& cell) const {
    // Along an axis a cell touches at most one other brick.
    const Index before = (cell == 0).cast<int>(), behind = (cell == kCells - 1).cast<int>();
    bool is = false;
    for_each(brick - before, brick + behind + 1,
             [&](const Index& beside) { is = is || number_of(beside) == 0; });
    return is;
  }

  void take_own(const FieldLayout& layout) {
    std::vector<float> exact(std::size_t{shape_.fine_count} * kBrickOwn);
    for_each(Index::Zero(), bricks_, [&](const Index& brick) {
      const std::uint32_t number = number_of(brick);
      if (number == 0) return;
      for_each(Index::Zero(), Index::Constant(kCells), [&](const Index& cell) {
        exact[own(number, cell)] = distance_at(middle_m(kCells * brick + cell, kCells));
      });
    });
    for_each(Index::Zero(), bricks_, [&](const Index& brick) {
      const std::uint32_t number = number_of(brick);
      if (number == 0) return;
      for_each(Index::Zero(), Index::Constant(kCells), [&](const Index& cell) {
        put(layout.fine, node(number, cell),
            is_at_border(brick, cell) ? refined(brick, cell) : own_coefficient(exact, brick, cell));
      });
    });
  }
  /// Of a cell of a fine brick, among such cells.
  static std::size_t own(std::uint32_t number, const Index& cell) {
    return std::size_t{number - 1} * kBrickOwn +
           static_cast<std::size_t>(cell.x() + kCells * (cell.y() + kCells * cell.z()));
  }
  /// The coefficient of a cell that is not at the border of the fine ones.
  [[nodiscard]] float own_coefficient(const std::vector<float>& exact, const Index& brick,
                                      const Index& cell) const {
    return sharpened(exact[own(number_of(brick), cell)], [&](int axis, int step) {
      Index other = cell, beside = brick;
      other[axis] += step;
      if (other[axis] < 0 || other[axis] >= kCells) {
        other[axis] -= step * kCells;
        beside[axis] += step;
      }
      return exact[own(number_of(beside), other)];
    });
  }

  void take_aprons(const FieldLayout& layout) {
    for_each(Index::Zero(), bricks_, [&](const Index& brick) {
      const std::uint32_t number = number_of(brick);
      if (number == 0) return;
      for_each(Index::Constant(-1), Index::Constant(kCells + 1), [&](const Index& cell) {
        const Index beside =
            (cell >= kCells)
                .select(Index::Constant(1), (cell < 0).select(Index::Constant(-1), Index::Zero()));
        if ((beside == 0).all()) return;
        const Index other = brick + beside, own = cell - kCells * beside;
        const std::uint32_t from = number_of(other);
        const float value = from != 0 ? get(layout.fine, node(from, own)) : refined(other, own);
        put(layout.fine, node(number, cell), value);
      });
    });
  }

  const ScalarField& distance_;
  Index bricks_ = Index::Zero();
  proto::FieldShape shape_{};
  std::vector<float> coarse_;
  std::vector<std::uint32_t> numbers_;
  std::vector<std::uint64_t> words_;
};

}  // namespace

DistanceField make_field(const Eigen::AlignedBox3d& solid_m, const FieldFineness& fineness,
                         const ScalarField& signed_distance_m, const ScalarField& stiffness_scale) {
  return FieldMaker(solid_m, fineness, signed_distance_m).make(stiffness_scale);
}

}  // namespace stillgrid::collision
