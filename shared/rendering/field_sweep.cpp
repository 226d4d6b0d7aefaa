#include "shared/rendering/field_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "proto/segment_header.hpp"

namespace stillgrid::rendering {
namespace {

constexpr std::uint32_t kMaxSteps = 64;
constexpr int kGoldenSections = 8;
/// Of the radius: the shortest step. Of the depth below the surface: how far that lets it go on.
constexpr double kShortestStep = 0.25, kInside = 0.5;

/// A straight way in the body's frame, and what is met on it.
class Way {
 public:
  Way(const collision::FieldView& field, const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m,
      double radius_m, SampleBudget& budget)
      : field_(field),
        from_m_(from_m),
        length_m_((to_m - from_m).norm()),
        direction_((to_m - from_m) / length_m_),
        radius_m_(radius_m),
        budget_(budget) {}

  /// The part of it from where on, and until where, the ball that holds the solid is within reach.
  [[nodiscard]] std::optional<std::pair<double, double>> near_part() const {
    const auto& c = field_.shape.centre_m;
    const Eigen::Vector3d to_centre_m = Eigen::Vector3d(c[0], c[1], c[2]) - from_m_;
    const double along_m = direction_.dot(to_centre_m);
    const double contact_distance_m = radius_m_ + double{field_.shape.bounding_radius_m};
    const double half2_m2 = contact_distance_m * contact_distance_m -
                            (to_centre_m - along_m * direction_).squaredNorm();
    // Written so that a NaN does not pass.
    if (!(half2_m2 > 0.0)) return std::nullopt;
    const double half_m = std::sqrt(half2_m2);
    return std::pair{std::max(0.0, along_m - half_m), std::min(length_m_, along_m + half_m)};
  }

  /// Nothing off the field's bricks, or where the budget is spent.
  [[nodiscard]] std::optional<collision::FieldContact> at(double way_m) const {
    if (!budget_.spend()) return std::nullopt;
    return collision::field_contact(field_, from_m_ + way_m * direction_, radius_m_);
  }
  [[nodiscard]] bool is_against(const collision::FieldContact& contact) const {
    return contact.normal.dot(direction_) < 0.0;
  }
  [[nodiscard]] double step_m(const std::optional<collision::FieldContact>& contact) const {
    const double shortest_m = kShortestStep * radius_m_;
    if (!contact) return shortest_m;
    const double inside_m = contact->depth_m - radius_m_;
    return std::max({shortest_m, -contact->depth_m, kInside * inside_m});
  }

 private:
  const collision::FieldView& field_;
  Eigen::Vector3d from_m_;
  double length_m_;
  Eigen::Vector3d direction_;
  double radius_m_;
  SampleBudget& budget_;
};

/// The contact that pushes back hardest.
struct Hardest {
  std::optional<collision::FieldContact> contact;
  double push_m = 0.0;  // for one N/m

  bool take(const collision::FieldContact& other) {
    const double other_m = other.stiffness_scale * other.depth_m;
    if (!(other_m > push_m)) return false;
    contact = other;
    push_m = other_m;
    return true;
  }
};

/// By golden sections: the push grows up to the hardest, and behind it falls.
void look_between(const Way& way, double low_m, double high_m, Hardest& hardest) {
  constexpr double kGolden = 0.6180339887498949;
  const auto push = [&](double at_m) {
    const auto contact = way.at(at_m);
    if (!contact || !way.is_against(*contact)) return -proto::kLargestNumber - at_m;  // behind
    hardest.take(*contact);
    return contact->stiffness_scale * contact->depth_m;
  };
  double a_m = high_m - kGolden * (high_m - low_m), b_m = low_m + kGolden * (high_m - low_m);
  double at_a = push(a_m), at_b = push(b_m);
  for (int i = 2; i < kGoldenSections; ++i) {
    if (at_a > at_b) {
      high_m = std::exchange(b_m, a_m);
      at_b = at_a;
      a_m = high_m - kGolden * (high_m - low_m);
      at_a = push(a_m);
    } else {
      low_m = std::exchange(a_m, b_m);
      at_a = at_b;
      b_m = low_m + kGolden * (high_m - low_m);
      at_b = push(b_m);
    }
  }
}

}  // namespace

std::optional<collision::FieldContact> met_on_the_way(const collision::FieldView& field,
                                                      const Eigen::Vector3d& from_m,
                                                      const Eigen::Vector3d& to_m, double radius_m,
                                                      SampleBudget& budget) noexcept {
  const Way way(field, from_m, to_m, radius_m, budget);
  const auto part = way.near_part();
  if (!part) return std::nullopt;
  auto [at_m, end_m] = *part;
  Hardest hardest;
  double before_m = at_m, low_m = at_m, high_m = at_m;  // the hardest is between the last two
  bool has_turned = false;
  for (std::uint32_t steps = 0; at_m < end_m && !has_turned; ++steps) {
    if (steps == kMaxSteps) budget.truncated = true;
    const auto contact = way.at(at_m);
    if (budget.truncated) return hardest.contact;
    const bool overlaps = contact && contact->depth_m > 0.0;
    if (at_m == 0.0 && overlaps) return std::nullopt;
    const double next_m = std::min(end_m, at_m + way.step_m(contact));
    if (contact && way.is_against(*contact)) {
      if (hardest.take(*contact)) std::tie(low_m, high_m) = std::pair(before_m, next_m);
    } else if (overlaps || hardest.contact) {
      if (!hardest.contact) std::tie(low_m, high_m) = std::pair(before_m, at_m);
      has_turned = true;
    }
    before_m = std::exchange(at_m, next_m);
  }
  if (hardest.contact || has_turned) look_between(way, low_m, high_m, hardest);
  return hardest.contact;
}

}  // namespace stillgrid::rendering
