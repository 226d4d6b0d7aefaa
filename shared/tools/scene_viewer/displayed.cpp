#include "shared/tools/scene_viewer/displayed.hpp"

#include <cstring>

#include "shared/display/displayed.hpp"

namespace stillgrid::scene_viewer {
namespace {

/// The hand's change of force is in the share.
display::SnapshotWeights weights_of(const proto::DisplayedSnapshot& shown) {
  return {.position = shown.position,
          .velocity_s = shown.velocity_s,
          .prediction_s = shown.prediction_s,
          .compliance_lag_s = shown.compliance_lag_s,
          .compliance_share = shown.force_change_N};
}

}  // namespace

std::optional<proto::DisplayedSnapshot> in_later_history(const proto::DisplayedSnapshot& shown,
                                                         std::uint64_t later) {
  if (later >= proto::kHistoryLength) return std::nullopt;
  const display::SnapshotWeights weights = display::in_later_snapshot(weights_of(shown), later);
  proto::DisplayedSnapshot told = shown;
  told.position = weights.position;
  told.velocity_s = weights.velocity_s;
  told.prediction_s = weights.prediction_s;
  told.compliance_lag_s = weights.compliance_lag_s;
  told.force_change_N = weights.compliance_share;
  return told;
}

std::array<float, 3> displayed_m(const proto::SphereRecord& record,
                                 const proto::DisplayedSnapshot& shown) {
  const display::SnapshotWeights weights = weights_of(shown);
  collision::RecordLine line;
  std::memcpy(&line, &record, sizeof line);
  Eigen::Vector3d at_m = display::displayed(line, weights, [&] { return record; }).position_m +
                         Eigen::Vector3d(shown.shift_m.data()) +
                         display::compliance_m_per_N(line, weights);
  if (at_m.hasNaN()) at_m = display::displayed_where_present(record, weights).position_m;
  const Eigen::Vector3f rounded = at_m.cast<float>();
  return {rounded.x(), rounded.y(), rounded.z()};
}

}  // namespace stillgrid::scene_viewer
