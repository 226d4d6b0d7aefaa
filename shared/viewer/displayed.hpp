#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "proto/scene_segment.hpp"
#include "proto/tool_segment.hpp"

namespace stillgrid {

/// The same image told by the history of one that came `later` images after it; nothing if that
/// history does not hold it. What a later image cannot tell is told as nearly as it can: the drift
/// by that image's velocity, and no answer.
[[nodiscard]] std::optional<proto::DisplayedImage> told_by_later(const proto::DisplayedImage& shown,
                                                                 std::uint64_t later);

/// Where a sphere was displayed; not a number in any axis where it was absent.
[[nodiscard]] std::array<float, 3> displayed_m(const proto::SphereRecord& record,
                                               const proto::DisplayedImage& shown);

}  // namespace stillgrid
