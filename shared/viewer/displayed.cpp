#include "shared/viewer/displayed.hpp"

#include <cstring>

#include "shared/display/displayed.hpp"

namespace stillgrid {
namespace {

/// The hand's change of force is in the share.
ImageWeights weights_of(const proto::DisplayedImage& shown) {
  return {.position = shown.position,
          .velocity_s = shown.velocity_s,
          .drift_s = shown.drift_s,
          .answer_lag_s = shown.answer_lag_s,
          .answer_share = shown.answer_N};
}

}  // namespace

std::optional<proto::DisplayedImage> told_by_later(const proto::DisplayedImage& shown,
                                                   std::uint64_t later) {
  if (later >= proto::kHistoryLength) return std::nullopt;
  const ImageWeights weights = in_later_image(weights_of(shown), later);
  proto::DisplayedImage told = shown;
  told.position = weights.position;
  told.velocity_s = weights.velocity_s;
  told.drift_s = weights.drift_s;
  told.answer_lag_s = weights.answer_lag_s;
  told.answer_N = weights.answer_share;
  return told;
}

std::array<float, 3> displayed_m(const proto::SphereRecord& record,
                                 const proto::DisplayedImage& shown) {
  const ImageWeights weights = weights_of(shown);
  RecordLine line;
  std::memcpy(&line, &record, sizeof line);
  Eigen::Vector3d at_m = displayed(line, weights, [&] { return record; }).position_m +
                         Eigen::Vector3d(shown.shift_m.data()) + compliance_m_per_N(line, weights);
  if (at_m.hasNaN()) at_m = displayed_where_present(record, weights).position_m;
  const Eigen::Vector3f rounded = at_m.cast<float>();
  return {rounded.x(), rounded.y(), rounded.z()};
}

}  // namespace stillgrid
