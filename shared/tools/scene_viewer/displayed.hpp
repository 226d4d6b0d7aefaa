#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "proto/scene_segment.hpp"
#include "proto/tool_segment.hpp"

namespace stillgrid::scene_viewer {

/// The same snapshot told by the history of one that came `later` snapshots after it; nothing if
/// that history does not hold it. What a later snapshot cannot tell is told as nearly as it can:
/// the predicted velocity by that snapshot's velocity, and no response.
[[nodiscard]] std::optional<proto::DisplayedSnapshot> in_later_history(
    const proto::DisplayedSnapshot& shown, std::uint64_t later);

/// Where a sphere was displayed, its response being one of `responses`; not a number in any axis
/// where it was absent.
[[nodiscard]] std::array<float, 3> displayed_m(const proto::SphereRecord& record,
                                               std::span<const proto::SphereResponse> responses,
                                               const proto::DisplayedSnapshot& shown);

}  // namespace stillgrid::scene_viewer
