#include "shared/rendering/field_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stillgrid::rendering {
namespace {

constexpr std::uint32_t kMaxSteps = 64;
constexpr int kBisections = 6;
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
    const double reach_m = radius_m_ + double{field_.shape.bounding_radius_m};
    const double half2_m2 = reach_m * reach_m - (to_centre_m - along_m * direction_).squaredNorm();
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

/// The contact that pushes hardest of those that overlap.
void keep_harder(std::optional<collision::FieldContact>& hardest,
                 const collision::FieldContact& contact) {
  const auto push = [](const collision::FieldContact& c) { return c.stiffness_scale * c.depth_m; };
  if (contact.depth_m > 0.0 && (!hardest || push(contact) > push(*hardest))) hardest = contact;
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
  std::optional<collision::FieldContact> hardest;
  double back_m = at_m;  // the last place before the field turns
  bool has_turned = false;
  for (std::uint32_t steps = 0; at_m < end_m && !has_turned; ++steps) {
    if (steps == kMaxSteps) budget.truncated = true;
    const auto contact = way.at(at_m);
    if (budget.truncated) return hardest;
    const bool overlaps = contact && contact->depth_m > 0.0;
    if (at_m == 0.0 && overlaps) return std::nullopt;
    if (contact && way.is_against(*contact)) {
      keep_harder(hardest, *contact);
    } else if (overlaps || hardest) {
      has_turned = true;
      continue;
    }
    back_m = at_m;
    at_m += way.step_m(contact);
  }
  double on_m = std::min(at_m, end_m);
  for (int i = 0; i < kBisections && (hardest || has_turned); ++i) {
    const double middle_m = 0.5 * (back_m + on_m);
    const auto contact = way.at(middle_m);
    const bool is_back = contact && way.is_against(*contact);
    if (is_back) keep_harder(hardest, *contact);
    (is_back ? back_m : on_m) = middle_m;
  }
  return hardest;
}

}  // namespace stillgrid::rendering
