#include "shared/reading/displayed.hpp"

#include <algorithm>
#include <cstring>

#include "shared/display/displayed.hpp"
#include "shared/display/response.hpp"

namespace stillgrid::reading {
namespace {

display::SnapshotWeights weights_of(const proto::DisplayedSnapshot& shown) {
  return {.position = shown.position,
          .velocity_s = shown.velocity_s,
          .prediction_s = shown.prediction_s,
          .compliance_lag_s = shown.compliance_lag_s};
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
  if (later > 0) told.modes = {};
  return told;
}

std::optional<proto::DisplayedSnapshot> displayed_in(const proto::DisplayedSnapshot& shown,
                                                     std::uint64_t scene_epoch,
                                                     std::uint64_t snapshot_id) {
  if (shown.snapshot_id == 0 || shown.scene_epoch != scene_epoch || shown.snapshot_id > snapshot_id)
    return std::nullopt;
  return in_later_history(shown, snapshot_id - shown.snapshot_id);
}

std::array<float, 3> displayed_m(const proto::SphereRecord& record,
                                 std::span<const proto::SphereResponse> responses,
                                 const proto::DisplayedSnapshot& shown) {
  const display::SnapshotWeights weights = weights_of(shown);
  collision::RecordLine line;
  std::memcpy(&line, &record, sizeof line);
  Eigen::Vector3d at_m = display::displayed(line, weights, [&] { return record; }).position_m;
  if (record.response > 0 && record.response <= responses.size()) {
    const proto::SphereResponse& response = responses[record.response - 1];
    const auto modes = Eigen::Map<const display::ResponseMatrix>(response.modes.front().data());
    at_m += modes.cast<double>() * Eigen::Map<const display::ModeDisplacements>(shown.modes.data());
  }
  const auto* const shift =
      std::find_if(shown.shifts.begin(), shown.shifts.end(),
                   [&](const proto::BodyShift& of) { return of.body == record.body; });
  if (shift != shown.shifts.end()) at_m += Eigen::Map<const Eigen::Vector3d>(shift->shift_m.data());
  if (at_m.hasNaN()) at_m = display::displayed_where_present(record, weights).position_m;
  const Eigen::Vector3f rounded = at_m.cast<float>();
  return {rounded.x(), rounded.y(), rounded.z()};
}

}  // namespace stillgrid::reading
