#include "shared/reading/displayed.hpp"

#include "shared/display/displayed.hpp"

namespace stillgrid::reading {

std::optional<proto::DisplayedSnapshot> in_later_history(const proto::DisplayedSnapshot& shown,
                                                         std::uint64_t later) {
  if (later >= proto::kHistoryLength) return std::nullopt;
  proto::DisplayedSnapshot told = shown;
  told.alpha = display::in_later_snapshot({.alpha = shown.alpha}, later).alpha;
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
                                 const proto::DisplayedSnapshot& shown) {
  const Eigen::Vector3f at_m =
      display::displayed(record, {.alpha = shown.alpha}).position_m.cast<float>();
  return {at_m.x(), at_m.y(), at_m.z()};
}

}  // namespace stillgrid::reading
