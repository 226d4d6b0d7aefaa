#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "proto/scene_segment.hpp"
#include "proto/tool_segment.hpp"

namespace stillgrid::reading {

/// The same snapshot told by the history of one that came `later` snapshots after it; nothing if
/// that history does not hold it. What lies before that history is told as if spheres went on
/// evenly.
[[nodiscard]] std::optional<proto::DisplayedSnapshot> in_later_history(
    const proto::DisplayedSnapshot& shown, std::uint64_t later);

/// What a tick displayed, as the history of snapshot `snapshot_id` of the scene of that epoch tells
/// it; nothing where it displayed none of that history.
[[nodiscard]] std::optional<proto::DisplayedSnapshot> displayed_in(
    const proto::DisplayedSnapshot& shown, std::uint64_t scene_epoch, std::uint64_t snapshot_id);

/// Where a sphere was displayed; not a number in any axis where it was absent.
[[nodiscard]] std::array<float, 3> displayed_m(const proto::SphereRecord& record,
                                               const proto::DisplayedSnapshot& shown);

}  // namespace stillgrid::reading
