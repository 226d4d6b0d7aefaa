#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "shared/publication/scene_segment.hpp"
#include "tests/fuzz/forbidden_bytes.hpp"

namespace stillgrid::fuzz {

/// Bytes between the parts of a valid segment that no reader has a reason to look at.
inline constexpr std::size_t kGapBytes = 4096;

/// A scene segment as SceneWriter makes it after three snapshots, but with gaps behind the fixed
/// part and behind each slot: the start that inputs are changes of. The same on every run.
[[nodiscard]] std::vector<std::byte> valid_scene();

/// A tool segment as ToolWriter makes it after two states, with the same gaps.
[[nodiscard]] std::vector<std::byte> valid_tool();

[[nodiscard]] const proto::SegmentHeader& header_of(std::span<const std::byte> segment);

/// What changes of a valid segment, in parts: `latest`, then of each slot its sequence and its
/// payload, a scene's in its header, its four arrays and its field.
[[nodiscard]] std::vector<std::span<std::byte>> changing_parts(std::span<std::byte> segment);

/// The gaps of a mapping of a valid segment, which begins at `start`.
[[nodiscard]] std::vector<std::unique_ptr<ForbiddenBytes>> forbid_gaps(
    const std::byte* start, std::span<const std::byte> segment);

}  // namespace stillgrid::fuzz
