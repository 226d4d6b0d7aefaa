#include "shared/viewer/displayed.hpp"

#include <Eigen/Core>
#include <algorithm>

#include "shared/collision/sphere_history.hpp"

namespace stillgrid {
namespace {

Eigen::Vector3d vector(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

/// Of a sphere that some image lacks, by those that it is in.
Eigen::Vector3d where_present_m(const proto::SphereRecord& record,
                                const proto::DisplayedImage& shown) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double presence = 0.0;
  for (std::size_t age = 0; age < proto::kHistoryLength; ++age) {
    const Eigen::Vector3d image_m = vector(position_m(record, age));
    const double weight = std::max(0.0, shown.position[age]);
    if (image_m.hasNaN()) continue;
    sum_m += weight * image_m;
    presence += weight;
  }
  return sum_m / presence;
}

}  // namespace

std::optional<proto::DisplayedImage> told_by_later(const proto::DisplayedImage& shown,
                                                   std::uint64_t later) {
  if (later == 0) return shown;
  if (later >= proto::kHistoryLength) return std::nullopt;
  proto::DisplayedImage told = shown;
  told.position = told_by_later(shown.position, later);
  told.velocity_s = told_by_later(shown.velocity_s, later);
  told.velocity_s[std::min<std::size_t>(later, told.velocity_s.size() - 1)] += shown.drift_s;
  told.drift_s = told.answer_lag_s = told.answer_N = 0.0;
  return told;
}

std::array<float, 3> displayed_m(const proto::SphereRecord& record,
                                 const proto::DisplayedImage& shown) {
  const bool answers = record.answer_m_N != std::array<float, 3>{};
  Eigen::Vector3d at_m =
      Eigen::Vector3d(shown.shift_m.data()) +
      (shown.drift_s - (answers ? shown.answer_lag_s : 0.0)) * vector(record.drift_m_s) +
      shown.answer_N * vector(record.answer_m_N);
  for (std::size_t age = 0; age < proto::kHistoryLength; ++age)
    if (shown.position[age] != 0.0) at_m += shown.position[age] * vector(position_m(record, age));
  const std::array<const proto::SphereImage*, 3> images = {&record.newest, &record.older[0],
                                                           &record.older[1]};
  for (std::size_t age = 0; age < images.size(); ++age)
    if (shown.velocity_s[age] != 0.0)
      at_m += shown.velocity_s[age] * vector(images[age]->velocity_m_s);
  if (at_m.hasNaN()) at_m = where_present_m(record, shown);
  const Eigen::Vector3f rounded = at_m.cast<float>();
  return {rounded.x(), rounded.y(), rounded.z()};
}

}  // namespace stillgrid
